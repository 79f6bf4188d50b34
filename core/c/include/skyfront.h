/* Skyfront for C11 and C++17: star windows and segmentation, without allocation, in the caller's memory.
 *
 * Made by cbindgen from core/c/src; do not edit. Every function can be called from any thread, as long as no two
 * calls use the same memory at the same time. Rows are row-major; pixel centres have whole coordinates from (0, 0).
 * What is not 0 among the results is one of SKYFRONT_ERROR_..., which keep their numbers for ever.
 */

#ifndef SKYFRONT_H
#define SKYFRONT_H

#include <stddef.h>
#include <stdint.h>

/* Bytes that are enough for a run: for memory that is static. skyfront_run_bytes() tells them at run time. */
#define SKYFRONT_RUN_BYTES(width, height, sources)                                                  \
  (SKYFRONT_RUN_FIXED_BYTES + (size_t)8 * (width) * (height) + (size_t)60 * (width)                 \
   + (size_t)((height) / 8 + 1) * ((width) / 16 + 2) + (size_t)SKYFRONT_SOURCE_BYTES * (sources))

/*
 The version of the interface: numbers and records of one version stay as they are.
 */
#define SKYFRONT_INTERFACE 1

/*
 The source touches the edge of the frame.
 */
#define SKYFRONT_SOURCE_TRUNCATED 1

/*
 A pixel reaches the camera's saturation.
 */
#define SKYFRONT_SOURCE_SATURATED 2

/*
 A pixel touches one that is listed as bad.
 */
#define SKYFRONT_SOURCE_MASKED 4

/*
 The source was divided from another one.
 */
#define SKYFRONT_SOURCE_BLENDED 8

/*
 No pixel stands above the sky: place and extent are those of the pixels.
 */
#define SKYFRONT_SOURCE_NO_FLUX 64

/*
 The source ends in a plateau, as a saturated star does.
 */
#define SKYFRONT_SOURCE_PLATEAU 1024

/*
 No error.
 */
#define SKYFRONT_OK 0

/*
 A parameter is out of its bounds.
 */
#define SKYFRONT_ERROR_PARAMETER 1

/*
 The image has an unsupported size.
 */
#define SKYFRONT_ERROR_SIZE 2

/*
 Memory or an array is too short.
 */
#define SKYFRONT_ERROR_LENGTH 3

/*
 No pixel is a finite number.
 */
#define SKYFRONT_ERROR_NOTHING_DEFINED 4

/*
 All pixels are equal.
 */
#define SKYFRONT_ERROR_CONSTANT 5

/*
 No part of the frame has enough pixels to measure its sky.
 */
#define SKYFRONT_ERROR_NO_SKY 6

/*
 The pixels show no noise.
 */
#define SKYFRONT_ERROR_NO_NOISE 7

/*
 The arithmetic cannot serve a setting.
 */
#define SKYFRONT_ERROR_ARITHMETIC 8

/*
 Two settings cannot go together.
 */
#define SKYFRONT_ERROR_TOGETHER 9

/*
 The scheme is not moved in slices.
 */
#define SKYFRONT_ERROR_FRONT 10

/*
 Other parts of the image have yet to answer.
 */
#define SKYFRONT_ERROR_WAITING 11

/*
 The memory of the run was changed between two calls.
 */
#define SKYFRONT_ERROR_CORRUPTED 12

/*
 The frame failed to deliver a row.
 */
#define SKYFRONT_ERROR_FRAME 13

/*
 A pointer is null or not aligned.
 */
#define SKYFRONT_ERROR_POINTER 14

/*
 There is no preset of this number.
 */
#define SKYFRONT_ERROR_PRESET 15

/*
 There is no setting of this name, or none with this value.
 */
#define SKYFRONT_ERROR_SETTING 16

/*
 The run has not ended yet.
 */
#define SKYFRONT_ERROR_NOT_DONE 17

/*
 There is no row or source of this number.
 */
#define SKYFRONT_ERROR_INDEX 18

/*
 The parameter table is damaged, or of another version.
 */
#define SKYFRONT_ERROR_TABLE 19

/*
 A snapshot was not taken up, and the run that was to take it up has lost its memory.
 */
#define SKYFRONT_ERROR_NOT_RESTORED 20

/*
 The frame was changed by others while the run read it.
 */
#define SKYFRONT_ERROR_FRAME_CHANGED 21

/*
 The least bytes of a packet.
 */
#define SKYFRONT_PACKET_LEAST_BYTES 64

/*
 The most bytes of a packet; of more memory only as much is used.
 */
#define SKYFRONT_PACKET_MOST_BYTES 65535

/*
 The parameter table of the setup.
 */
#define SKYFRONT_PRESET_TABLE 0

/*
 The paper's setting for frames that are nearly noiseless.
 */
#define SKYFRONT_PRESET_PAPER_F160 1

/*
 The paper's setting for real frames.
 */
#define SKYFRONT_PRESET_PAPER_REAL 2

/*
 Bytes of a run beside its planes, rows and sources, at most.
 */
#define SKYFRONT_RUN_FIXED_BYTES 4096

/*
 Bytes of a source in a run's memory, at most.
 */
#define SKYFRONT_SOURCE_BYTES 112

/*
 The window reaches beyond the frame, so that it is cut off.
 */
#define SKYFRONT_STAR_EDGE 1

/*
 A pixel of the star reaches the camera's saturation; it is left out.
 */
#define SKYFRONT_STAR_SATURATED 2

/*
 A pixel of the star is listed as bad or is brighter than its neighbours allow; it is left out.
 */
#define SKYFRONT_STAR_HOT 4

/*
 Another source is near the star.
 */
#define SKYFRONT_STAR_BLENDED 8

/*
 No star is in the window: place as predicted, infinite variances.
 */
#define SKYFRONT_STAR_LOST 16

/*
 A run, in the caller's memory.
 */
typedef struct skyfront_run skyfront_run;

/*
 A run of the default, in the caller's memory.
 */
typedef struct skyfront_search skyfront_search;

/*
 What a source of the default measures above the sky, in 144 bytes. Errors count the noise of its light where the
 camera is known.
 */
typedef struct skyfront_measured {
  /*
   Its label in the map, from 1.
   */
  uint32_t label;
  /*
   Pixels.
   */
  uint32_t area;
  /*
   Sum of SKYFRONT_SOURCE_....
   */
  uint32_t flags;
  /*
   Its greatest pixel, counts; NaN where all are bad.
   */
  float peak;
  /*
   Column and row of the first such pixel.
   */
  uint32_t peak_place[2];
  /*
   First and last column.
   */
  uint32_t columns[2];
  /*
   First and last row.
   */
  uint32_t rows[2];
  /*
   Light above the sky, counts.
   */
  double flux;
  /*
   Its standard deviation, counts.
   */
  double flux_error;
  /*
   Column of the centre, pixels.
   */
  double x;
  /*
   Row of the centre, pixels.
   */
  double y;
  /*
   Variance of the column, pixels^2; NaN where nothing stands above the sky, as the next two.
   */
  double errx2;
  /*
   Variance of the row, pixels^2.
   */
  double erry2;
  /*
   Covariance of column and row, pixels^2.
   */
  double errxy;
  /*
   Second moment along the columns, pixels^2.
   */
  double x2;
  /*
   Second moment along the rows, pixels^2.
   */
  double y2;
  /*
   The mixed second moment, pixels^2.
   */
  double xy;
  /*
   Mean sky, counts.
   */
  double background;
  /*
   Mean standard deviation of the sky, counts.
   */
  double noise;
  /*
   Mean of the pixels along the outline above the sky, counts.
   */
  double threshold;
} skyfront_measured;

/*
 Where the next packet of a product begins: {number of the product} before the first. A copy of it writes a
 packet again.
 */
typedef struct skyfront_cursor {
  /*
   The caller's number of the product, such as that of the frame.
   */
  uint32_t product;
  /*
   Packets written.
   */
  uint32_t packet;
  /*
   Stars, pixels of the map, or cut-outs written.
   */
  uint32_t item;
  /*
   Pixels of the next cut-out written.
   */
  uint32_t pixel;
} skyfront_cursor;

/*
 What a window holds, in 32 bytes.
 */
typedef struct skyfront_star {
  /*
   Column of the centre, pixels.
   */
  float x;
  /*
   Row of the centre, pixels.
   */
  float y;
  /*
   All light of the star, counts.
   */
  float flux;
  /*
   The flux over its standard deviation.
   */
  float snr;
  /*
   Variance of x, pixels squared.
   */
  float errx2;
  /*
   Variance of y, pixels squared.
   */
  float erry2;
  /*
   Covariance of x and y, pixels squared.
   */
  float errxy;
  /*
   SKYFRONT_STAR_... together.
   */
  uint32_t flags;
} skyfront_star;

/*
 Where a star is expected, and how far around to look.
 */
typedef struct skyfront_window {
  /*
   Predicted column of the star, pixels.
   */
  float x;
  /*
   Predicted row of the star, pixels.
   */
  float y;
  /*
   Columns, 8 to 64.
   */
  uint16_t width;
  /*
   Rows, 8 to 64.
   */
  uint16_t height;
} skyfront_window;

/*
 A setting by its name, as `skyfront parameters` lists them: {"t-max", "30"}.
 */
typedef struct skyfront_setting {
  /*
   The name.
   */
  const char *name;
  /*
   The value.
   */
  const char *value;
} skyfront_setting;

/*
 What a run is to do.
 */
typedef struct skyfront_setup {
  /*
   SKYFRONT_PRESET_...
   */
  uint32_t preset;
  /*
   Columns of the frame.
   */
  size_t width;
  /*
   Rows of the frame.
   */
  size_t height;
  /*
   The most sources that are catalogued; more are counted.
   */
  size_t sources;
  /*
   Settings other than the preset's; null for none.
   */
  const struct skyfront_setting *settings;
  /*
   How many.
   */
  size_t setting_count;
  /*
   A parameter table, for SKYFRONT_PRESET_TABLE; else null.
   */
  const uint8_t *table;
  /*
   Its bytes.
   */
  size_t table_bytes;
} skyfront_setup;

/*
 How far a run is, and at its end what it found.
 */
typedef struct skyfront_progress {
  /*
   1 when all is done, else 0.
   */
  uint32_t done;
  /*
   Rows of work done.
   */
  uint32_t rows;
  /*
   The most rows of work that there can be.
   */
  uint32_t most_rows;
  /*
   Steps that the front took; 0 before the end, as all that follows.
   */
  uint32_t steps;
  /*
   Sources.
   */
  uint32_t sources;
  /*
   Sources in the catalogue; fewer where it was too short.
   */
  uint32_t catalogued;
  /*
   Pixels inside the outlines.
   */
  uint32_t mask_pixels;
  /*
   Pixels inside the outlines without a label, because the table of labels was full.
   */
  uint32_t unlabelled;
} skyfront_progress;

/*
 Writes row `y` of the frame, `width` pixels, to `out` and returns 0; another number stops the call, which can
 be made again. A pixel that is not finite is undefined.
 */
typedef int32_t (*skyfront_row)(void *context,
                                size_t y,
                                float *out,
                                size_t width);

/*
 A source: the mean of its pixels' places weighted by their light, and its ellipse.
 */
typedef struct skyfront_source {
  /*
   Its label in the map, from 1.
   */
  uint32_t label;
  /*
   Pixels.
   */
  uint32_t area;
  /*
   Column of the centre, pixels.
   */
  float x;
  /*
   Row of the centre, pixels.
   */
  float y;
  /*
   Sum of its pixels, counts.
   */
  float sum;
  /*
   Its greatest pixel, counts.
   */
  float peak;
  /*
   Root mean square along the major axis, pixels.
   */
  float a;
  /*
   Root mean square along the minor axis, pixels.
   */
  float b;
  /*
   From the x axis to the major axis, radians.
   */
  float theta;
  /*
   First and last column.
   */
  uint32_t columns[2];
  /*
   First and last row.
   */
  uint32_t rows[2];
} skyfront_source;

/*
 A pixel that is never to be used.
 */
typedef struct skyfront_bad_pixel {
  /*
   Its column.
   */
  uint16_t x;
  /*
   Its row.
   */
  uint16_t y;
} skyfront_bad_pixel;

/*
 What is known of the camera.
 */
typedef struct skyfront_camera {
  /*
   The value of a pixel without light, counts, 0 to 65536.
   */
  float black;
  /*
   Electrons per count, 0.001 to 10^6.
   */
  float gain;
  /*
   Noise of a pixel without light, electrons, 0 to 10^6.
   */
  float read_noise;
  /*
   Pixels from this value on are saturated, counts, 0 to 65536.
   */
  float saturation;
  /*
   Standard deviation of a star's image, pixels, 0.5 to 3.
   */
  float psf_sigma;
} skyfront_camera;

/*
 What a run of the default is to work on.
 */
typedef struct skyfront_search_setup {
  /*
   The frame, 16 bits per pixel in the processor's byte order; null where it has 8.
   */
  const uint16_t *pixels_u16;
  /*
   The frame, 8 bits per pixel; null where it has 16.
   */
  const uint8_t *pixels_u8;
  /*
   Columns, 8 to 65535.
   */
  size_t width;
  /*
   Rows, 8 to 65535.
   */
  size_t height;
  /*
   Pixels from one row to the next.
   */
  size_t stride;
  /*
   Peaks that there is room for; 0 for as many as there can be. Pixels of more are in no source, and counted.
   */
  size_t regions;
  /*
   Pixels that are never to be used, row by row and along these; null for none.
   */
  const struct skyfront_bad_pixel *bad_pixels;
  /*
   How many.
   */
  size_t bad_pixel_count;
  /*
   Settings other than the default's; null for none.
   */
  const struct skyfront_setting *settings;
  /*
   How many.
   */
  size_t setting_count;
  /*
   What is known of the camera, copied: its gain counts in the errors of sources, its saturation in their flags; the
   sky, its noise and the width of stars are measured. Null where nothing is.
   */
  const struct skyfront_camera *camera;
} skyfront_search_setup;

/*
 How far a run of the default is, and at its end what it found.
 */
typedef struct skyfront_search_progress {
  /*
   Work done, in pixels of a pass.
   */
  uint64_t work;
  /*
   The most work that there can be.
   */
  uint64_t most_work;
  /*
   1 when all is done, else 0.
   */
  uint32_t done;
  /*
   Sources; 0 before the end, as all that follows. Labels run from 1 to this.
   */
  uint32_t sources;
  /*
   Pixels of sources.
   */
  uint32_t mask_pixels;
  /*
   Peaks for which there was no room.
   */
  uint32_t unlabelled;
} skyfront_search_progress;

/*
 Takes `count` bytes of a snapshot and returns 0; another number stops the call.
 */
typedef int32_t (*skyfront_write)(void *context,
                                  const uint8_t *bytes,
                                  size_t count);

/*
 Gives the next `count` bytes of a snapshot and returns 0; another number stops the call.
 */
typedef int32_t (*skyfront_read)(void *context,
                                 uint8_t *bytes,
                                 size_t count);

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The version of the interface that the library has; compare it with `SKYFRONT_INTERFACE`.
 */
uint32_t skyfront_interface(void);

/*
 CRC-32 (IEEE 802.3, as in zlib) of bytes; 0 for a null pointer.

 # Safety
 `bytes` points to `count` readable bytes.
 */
uint32_t skyfront_crc32(const uint8_t *bytes,
                        size_t count);

/*
 Bytes that the catalogue of so many sources needs; 0 where they cannot be counted.
 */
size_t skyfront_catalogue_bytes(size_t sources);

/*
 Begins to measure the sources of a run of the default that has ended, in `memory` of at least
 `skyfront_catalogue_bytes()` bytes for them, which belongs to the run until another catalogue is begun; a run that
 takes up a snapshot has none.

 # Safety
 `search` was started; `memory` points to `bytes` bytes.
 */
int32_t skyfront_search_measure_start(struct skyfront_search *search,
                                      void *memory,
                                      size_t bytes);

/*
 Measures at most `rows` rows of the frame, or as many pieces of sources as these have pixels; `done` takes 1 when all
 is measured, else 0, and may be null. The same numbers come out whatever the slices.

 # Safety
 `search` was started.
 */
int32_t skyfront_search_measure(struct skyfront_search *search,
                                size_t rows,
                                uint32_t *done);

/*
 Source `index`, from 0, of a catalogue that is measured: that of label `index + 1`.

 # Safety
 `search` was started; `source` points to a record.
 */
int32_t skyfront_search_source(const struct skyfront_search *search,
                               size_t index,
                               struct skyfront_measured *source);

/*
 What a number says, as a text that stays; "unknown error" for a number that is none.
 */
const char *skyfront_error_text(int32_t error);

/*
 Writes the next packet of stars to `out`, and its bytes to `length`: 0 where all are written.

 # Safety
 `cursor`, `stars`, `out` and `length` point to one cursor, `count` stars, `bytes` bytes and one number.
 */
int32_t skyfront_packet_stars(struct skyfront_cursor *cursor,
                              const struct skyfront_star *stars,
                              size_t count,
                              uint8_t *out,
                              size_t bytes,
                              size_t *length);

/*
 Writes the next packet of the map of labels of a run that has ended, as `skyfront_packet_stars` does.

 # Safety
 `run` was started; `cursor`, `out` and `length` as for `skyfront_packet_stars`.
 */
int32_t skyfront_packet_labels(struct skyfront_cursor *cursor,
                               const struct skyfront_run *run,
                               uint8_t *out,
                               size_t bytes,
                               size_t *length);

/*
 Writes the next packet of cut-outs, the parts of windows that lie in a frame of 16 bits per pixel, as
 `skyfront_packet_stars` does.

 # Safety
 `pixels` points to `stride * (height - 1) + width` pixels, `windows` to `window_count` windows; `cursor`, `out` and
 `length` as for `skyfront_packet_stars`.
 */
int32_t skyfront_packet_cutouts_u16(struct skyfront_cursor *cursor,
                                    const uint16_t *pixels,
                                    size_t width,
                                    size_t height,
                                    size_t stride,
                                    const struct skyfront_window *windows,
                                    size_t window_count,
                                    uint8_t *out,
                                    size_t bytes,
                                    size_t *length);

/*
 The same of a frame of 8 bits per pixel.

 # Safety
 As for `skyfront_packet_cutouts_u16`.
 */
int32_t skyfront_packet_cutouts_u8(struct skyfront_cursor *cursor,
                                   const uint8_t *pixels,
                                   size_t width,
                                   size_t height,
                                   size_t stride,
                                   const struct skyfront_window *windows,
                                   size_t window_count,
                                   uint8_t *out,
                                   size_t bytes,
                                   size_t *length);

/*
 Bytes that a run needs; 0 where they cannot be counted.
 */
size_t skyfront_run_bytes(size_t width,
                          size_t height,
                          size_t sources);

/*
 Sets up a run in `memory` of at least `skyfront_run_bytes()` bytes, which belongs to the run from now on and
 must not be moved; there is nothing to be freed. `run` takes the run, `message` (null for none) what is wrong
 in words, cut to `message_bytes`.

 # Safety
 `memory` points to `bytes` bytes, `setup` to a setup whose settings are texts that end with a zero, `run` to a
 pointer, `message` to `message_bytes` bytes.
 */
int32_t skyfront_run_start(void *memory,
                           size_t bytes,
                           const struct skyfront_setup *setup,
                           struct skyfront_run **run,
                           char *message,
                           size_t message_bytes);

/*
 Bytes of a parameter table.
 */
size_t skyfront_table_bytes(void);

/*
 Writes the parameters of a setup as a parameter table of `skyfront_table_bytes()` bytes, with a CRC-32 at its
 end: what is made on the ground and loaded on board. `message` as for `skyfront_run_start`.

 # Safety
 `setup` points to a setup whose settings are texts that end with a zero, `table` to `table_bytes` bytes,
 `message` to `message_bytes` bytes.
 */
int32_t skyfront_table_write(const struct skyfront_setup *setup,
                             uint8_t *table,
                             size_t table_bytes,
                             char *message,
                             size_t message_bytes);

/*
 Checks a parameter table: length, version, CRC-32, and every value against its bounds.

 # Safety
 `table` points to `table_bytes` bytes, `message` to `message_bytes` bytes.
 */
int32_t skyfront_table_check(const uint8_t *table,
                             size_t table_bytes,
                             char *message,
                             size_t message_bytes);

/*
 Does at most `rows` rows of the run on a frame of 16 bits per pixel, in the processor's byte order, whose rows
 are `stride` pixels apart. The same results come out whatever the slices. `progress` may be null.

 # Safety
 `run` was started; `pixels` points to `stride * (height - 1) + width` pixels, the same in every call of a run.
 */
int32_t skyfront_run_poll_u16(struct skyfront_run *run,
                              size_t rows,
                              const uint16_t *pixels,
                              size_t stride,
                              struct skyfront_progress *progress);

/*
 The same on a frame of 8 bits per pixel.

 # Safety
 As for `skyfront_run_poll_u16`.
 */
int32_t skyfront_run_poll_u8(struct skyfront_run *run,
                             size_t rows,
                             const uint8_t *pixels,
                             size_t stride,
                             struct skyfront_progress *progress);

/*
 The same on rows that a function delivers, whenever they are asked for and always the same; `context` is passed
 on to it. When it returns another number than 0 the result is SKYFRONT_ERROR_FRAME.

 # Safety
 `run` was started; `row` writes no more than it is asked for, and does not touch the run.
 */
int32_t skyfront_run_poll_rows(struct skyfront_run *run,
                               size_t rows,
                               skyfront_row row,
                               void *context,
                               struct skyfront_progress *progress);

/*
 Row `y` of the map of labels of a run that has ended, `width` of them; 0 is the background.

 # Safety
 `run` was started; `labels` points to as many numbers as the frame has columns.
 */
int32_t skyfront_run_labels(const struct skyfront_run *run,
                            size_t y,
                            uint32_t *labels);

/*
 A source of a run that has ended, `index` counting from 0.

 # Safety
 `run` was started; `source` points to a source.
 */
int32_t skyfront_run_source(const struct skyfront_run *run,
                            size_t index,
                            struct skyfront_source *source);

/*
 Bytes that a run of the default needs, whatever its settings; 0 where they cannot be counted.
 */
size_t skyfront_search_bytes(size_t width,
                             size_t height,
                             size_t regions);

/*
 Sets up a run of the default in `memory` of at least `skyfront_search_bytes()` bytes, which belongs to the run
 from now on and must not be moved; there is nothing to be freed. The frame must stay where it is, and what it
 is, until the run has ended: one that others have written to is SKYFRONT_ERROR_FRAME_CHANGED. `search` takes
 the run, `message` as for `skyfront_run_start`.

 # Safety
 `memory` points to `bytes` bytes, `setup` to a setup whose frame has `stride * (height - 1) + width` pixels and
 whose settings are texts that end with a zero, `search` to a pointer, `message` to `message_bytes` bytes. Frame
 and bad pixels outlive the run.
 */
int32_t skyfront_search_start(void *memory,
                              size_t bytes,
                              const struct skyfront_search_setup *setup,
                              struct skyfront_search **search,
                              char *message,
                              size_t message_bytes);

/*
 Does at most `rows` rows of the step under way. The same results come out whatever the slices. `progress` may be
 null. After an error every further call returns the same.

 # Safety
 `search` was started.
 */
int32_t skyfront_search_poll(struct skyfront_search *search,
                             size_t rows,
                             struct skyfront_search_progress *progress);

/*
 Row `y` of the map of labels of a run of the default that has ended, `width` of them; 0 is the background.

 # Safety
 `search` was started; `labels` points to as many numbers as the frame has columns.
 */
int32_t skyfront_search_labels(const struct skyfront_search *search,
                               size_t y,
                               uint32_t *labels);

/*
 Writes a run of the default out as a snapshot, in pieces of at most 64 bytes; `context` is passed on to `write`.
 When that returns another number than 0 the result is SKYFRONT_ERROR_FRAME, and the run goes on.

 # Safety
 `search` was started; `write` reads no more than it is given.
 */
int32_t skyfront_search_save(struct skyfront_search *search,
                             skyfront_write write,
                             void *context);

/*
 Takes up the run of a snapshot in the place of this one, which has the same setup and the same frame.
 SKYFRONT_ERROR_NOT_RESTORED where it is damaged, foreign or ends early: this run is lost then, until a snapshot
 is taken up.

 # Safety
 `search` was started; `read` writes no more than it is asked for.
 */
int32_t skyfront_search_restore(struct skyfront_search *search,
                                skyfront_read read,
                                void *context);

/*
 Centres the brightest star of each window on a frame of 16 bits per pixel, in the processor's byte order.
 `stride` is the number of pixels from one row to the next; `stars` takes a record for each window. After an
 error nothing has been written.

 # Safety
 `pixels` points to `stride * (height - 1) + width` pixels, `camera` to a camera, `windows`, `bad_pixels` and
 `stars` to as many elements as there are windows, bad pixels and windows.
 */
int32_t skyfront_track_u16(const uint16_t *pixels,
                           size_t width,
                           size_t height,
                           size_t stride,
                           const struct skyfront_camera *camera,
                           const struct skyfront_window *windows,
                           size_t window_count,
                           const struct skyfront_bad_pixel *bad_pixels,
                           size_t bad_pixel_count,
                           struct skyfront_star *stars);

/*
 The same on a frame of 8 bits per pixel.

 # Safety
 As for `skyfront_track_u16`.
 */
int32_t skyfront_track_u8(const uint8_t *pixels,
                          size_t width,
                          size_t height,
                          size_t stride,
                          const struct skyfront_camera *camera,
                          const struct skyfront_window *windows,
                          size_t window_count,
                          const struct skyfront_bad_pixel *bad_pixels,
                          size_t bad_pixel_count,
                          struct skyfront_star *stars);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SKYFRONT_H */
