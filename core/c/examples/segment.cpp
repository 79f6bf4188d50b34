// Segmentation in C++17: a run in static memory, in slices, on rows that a function delivers.

#include "skyfront.h"
#include <stdio.h>

namespace {

constexpr size_t width = 48, height = 36, sources = 16;

// The memory of the run: enough for it, and known when the program is built.
alignas(16) uint8_t memory[SKYFRONT_RUN_BYTES(width, height, sources)];

// A sky of 100 counts with two discs, the second of them fainter.
int32_t row(void *context, size_t y, float *out, size_t columns)
{
  ++*static_cast<uint32_t *>(context);
  for (size_t x = 0; x < columns; ++x) {
    const int dx = static_cast<int>(x) - 14, dy = static_cast<int>(y) - 12, ex = dx - 20, ey = dy - 10;
    const int first = dx * dx + dy * dy, second = ex * ex + ey * ey;
    out[x] = 100.0f + static_cast<float>((x * 7 + y * 3) % 5) + (first < 30 ? 900.0f : 0.0f)
             + (second < 20 ? 500.0f : 0.0f);
  }
  return 0;
}

int32_t segment()
{
  const skyfront_setting settings[] = {{"min-area", "3"}};
  const skyfront_setup setup = {SKYFRONT_PRESET_PAPER_F160, width, height, sources, settings, 1, nullptr, 0};
  char message[96];
  skyfront_run *run = nullptr;
  if (const int32_t error = skyfront_run_start(memory, sizeof memory, &setup, &run, message, sizeof message)) {
    printf("error %s: %s\n", skyfront_error_text(error), message);
    return error;
  }
  uint32_t calls = 0;
  skyfront_progress progress = {};
  while (!progress.done) {
    if (const int32_t error = skyfront_run_poll_rows(run, 8, row, &calls, &progress)) {
      return error;
    }
    // Other tasks have their turn here.
  }
  static uint32_t labels[height * width];
  for (size_t y = 0; y < height; ++y) {
    if (const int32_t error = skyfront_run_labels(run, y, labels + y * width)) {
      return error;
    }
  }
  skyfront_source brightest = {};
  for (size_t index = 0; index < progress.catalogued; ++index) {
    skyfront_source source;
    if (const int32_t error = skyfront_run_source(run, index, &source)) {
      return error;
    }
    brightest = source.sum > brightest.sum ? source : brightest;
  }
  const auto crc = [](const void *bytes, size_t count) {
    return static_cast<unsigned long>(skyfront_crc32(static_cast<const uint8_t *>(bytes), count));
  };
  printf("resource stars %lu sources\n", static_cast<unsigned long>(progress.sources));
  printf("digest c/run/labels %08lx\n", crc(labels, sizeof labels));
  printf("digest c/run/source %08lx\n", crc(&brightest, sizeof brightest));
  printf("done\n");
  return calls > 0 ? SKYFRONT_OK : SKYFRONT_ERROR_FRAME;
}

} // namespace

int main()
{
  return segment() == SKYFRONT_OK ? 0 : 1;
}
