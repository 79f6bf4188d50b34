/* Starts a program of C or C++ on the Cortex-M7 of QEMU's MPS2 board AN500, and prints on its serial line. */

#include <stdint.h>

extern uint32_t _stack_top[], _data_start[], _data_end[], _data_source[], _bss_start[], _bss_end[];

int main(void);
void start(void);
void stop(void);
int _write(int file, const char *text, int length);

/* The stack, where to begin, and fourteen faults. */
struct vectors {
  uint32_t *stack;
  void (*handlers[15])(void);
};

__attribute__((section(".vectors"), used)) static const struct vectors vectors = {
  _stack_top, {start, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop},
};

static volatile uint32_t *const uart = (uint32_t *)0x40004000;

void start(void)
{
  *(volatile uint32_t *)0xE000ED88 |= 0x00F00000; /* The FPU may run. */
  __asm volatile("dsb\n\tisb" ::: "memory");
  for (uint32_t *to = _data_start, *from = _data_source; to < _data_end;) {
    *to++ = *from++;
  }
  for (uint32_t *to = _bss_start; to < _bss_end;) {
    *to++ = 0;
  }
  uart[4] = 16;
  uart[2] = 1;
  main();
  stop();
}

/* Ends the emulation; a program that was stopped by a fault has not printed its last line. */
void stop(void)
{
  for (;;) {
    __asm volatile("mov r0, #0x18\n\tldr r1, =0x20026\n\tbkpt 0xab" ::: "r0", "r1");
  }
}

int _write(int file, const char *text, int length)
{
  (void)file;
  for (int at = 0; at < length; at++) {
    uart[0] = (uint8_t)text[at];
  }
  return length;
}
