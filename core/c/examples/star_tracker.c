/* A star tracker in C11: stars in windows of a frame as it lies in the camera's buffer. */

#include "skyfront.h"
#include <stdio.h>

enum { WIDTH = 96, HEIGHT = 72, STRIDE = 100, STARS = 12, SIDE = 15 };

static uint16_t frame[HEIGHT * STRIDE];

/* The light of a star on 5 x 5 pixels, in hundredths of its peak: off its middle pixel, up and to the right. */
static const uint16_t light[5][5] = {
  {2, 5, 7, 5, 2}, {8, 24, 33, 24, 8}, {15, 51, 84, 56, 19}, {13, 45, 76, 51, 17}, {5, 19, 31, 21, 7},
};

/* Draws a sky of 100 counts with noise, and stars that grow brighter from the first to the last. */
static void draw(void)
{
  uint32_t state = 7;
  for (uint32_t at = 0; at < HEIGHT * STRIDE; at++) {
    state = state * UINT32_C(1664525) + UINT32_C(1013904223);
    frame[at] = (uint16_t)(92 + (state >> 28));
  }
  for (uint32_t star = 0; star < STARS; star++) {
    uint32_t column = 10 + star % 4 * 24, row = 10 + star / 4 * 24, peak = 200 + star * 250;
    for (uint32_t y = 0; y < 5; y++) {
      for (uint32_t x = 0; x < 5; x++) {
        frame[(row + y) * STRIDE + column + x] += (uint16_t)(light[y][x] * peak / 100);
      }
    }
  }
}

static unsigned long crc(const void *bytes, size_t count)
{
  return (unsigned long)skyfront_crc32((const uint8_t *)bytes, count);
}

/* The whole frame, for a tracker that does not know yet where it looks: sources, and what they measure. */
static int32_t search(const skyfront_camera *camera, const skyfront_bad_pixel *bad)
{
  enum { MOST = 64 };
  static uint64_t memory[32768], sums[4096];
  static skyfront_measured sources[MOST];
  static uint32_t labels[HEIGHT][WIDTH];
  const skyfront_search_setup setup = {
    .pixels_u16 = frame, .width = WIDTH, .height = HEIGHT, .stride = STRIDE, .regions = 200,
    .bad_pixels = bad, .bad_pixel_count = 1, .camera = camera,
  };
  skyfront_search *run = NULL;
  skyfront_search_progress progress = {.done = 0};
  uint32_t done = 0;
  char message[96] = "";
  int32_t error = skyfront_search_start(memory, sizeof memory, &setup, &run, message, sizeof message);
  while (error == SKYFRONT_OK && !progress.done) {
    error = skyfront_search_poll(run, 8, &progress);
    /* Other tasks have their turn here. */
  }
  for (size_t y = 0; error == SKYFRONT_OK && y < HEIGHT; y++) {
    error = skyfront_search_labels(run, y, labels[y]);
  }
  if (error == SKYFRONT_OK) {
    error = skyfront_search_measure_start(run, sums, sizeof sums);
  }
  while (error == SKYFRONT_OK && !done) {
    error = skyfront_search_measure(run, 8, &done);
  }
  for (size_t at = 0; error == SKYFRONT_OK && at < progress.sources && at < MOST; at++) {
    error = skyfront_search_source(run, at, &sources[at]);
  }
  if (error != SKYFRONT_OK) {
    printf("error %s: %s\n", skyfront_error_text(error), message);
    return error;
  }
  printf("resource search %lu sources\n", (unsigned long)progress.sources);
  printf("digest c/search/labels %08lx\n", crc(labels, sizeof labels));
  printf("digest c/search/sources %08lx\n", crc(sources, sizeof sources));
  return SKYFRONT_OK;
}

int main(void)
{
  const skyfront_camera camera = {.black = 64, .gain = 2, .read_noise = 7, .saturation = 4095, .psf_sigma = 1.1f};
  const skyfront_bad_pixel bad[] = {{.x = 11, .y = 13}};
  skyfront_window windows[STARS];
  skyfront_star stars[STARS];
  if (skyfront_interface() != SKYFRONT_INTERFACE) {
    return 1;
  }
  draw();
  for (uint32_t star = 0; star < STARS; star++) {
    windows[star] = (skyfront_window){
      .x = (float)(11 + star % 4 * 24), .y = (float)(13 + star / 4 * 24), .width = SIDE, .height = SIDE,
    };
  }
  int32_t error = skyfront_track_u16(frame, WIDTH, HEIGHT, STRIDE, &camera, windows, STARS, bad, 1, stars);
  if (error != SKYFRONT_OK) {
    printf("error %s\n", skyfront_error_text(error));
    return 1;
  }
  unsigned long found = 0;
  for (uint32_t star = 0; star < STARS; star++) {
    found += (stars[star].flags & SKYFRONT_STAR_LOST) == 0;
  }
  printf("resource stars %lu stars\n", found);
  /* The records are the same bytes on every little-endian machine. */
  printf("digest c/track/stars %08lx\n", crc(stars, sizeof stars));
  /* What goes to the ground: packets of at most 128 bytes, here together in one stretch of memory. Each is written over
     the checksum of the one before, because a checksum over that too is the same whatever the packet holds. */
  static uint8_t sent[96 * 128];
  skyfront_cursor cursor = {.product = 1};
  size_t all = 0, length = 1;
  while (error == SKYFRONT_OK && length > 0 && all + 128 <= sizeof sent) {
    error = skyfront_packet_stars(&cursor, stars, STARS, sent + all, 128, &length);
    all += length > 0 ? length - 4 : 0;
  }
  cursor = (skyfront_cursor){.product = 1};
  length = 1;
  while (error == SKYFRONT_OK && length > 0 && all + 128 <= sizeof sent) {
    error = skyfront_packet_cutouts_u16(&cursor, frame, WIDTH, HEIGHT, STRIDE, windows, STARS, sent + all, 128, &length);
    all += length > 0 ? length - 4 : 0;
  }
  printf("digest c/track/packets %08lx\n", crc(sent, all));
  if (error != SKYFRONT_OK || length > 0 || search(&camera, bad) != SKYFRONT_OK) {
    return 1;
  }
  printf("done\n");
  return 0;
}
