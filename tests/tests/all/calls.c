/* Calls that are wrong, each with the number that must come back. */

#include "skyfront.h"
#include <stdio.h>
#include <string.h>

enum { W = 48, H = 36, N = 4 };

static unsigned char memory[SKYFRONT_RUN_BYTES(W, H, N)];
static uint16_t words[W * H];
static uint8_t bytes[W * H];
static int failures;

static void is(const char *what, long found, long wanted)
{
  if (found != wanted) {
    printf("%s: %ld, wanted %ld\n", what, found, wanted);
    failures++;
  }
}

static int32_t refuse(void *context, size_t y, float *out, size_t width)
{
  (void)context, (void)y, (void)out, (void)width;
  return 5;
}

static void windows(void)
{
  const skyfront_camera camera = {64, 2, 7, 4095, 1}, dark = {64, 0, 7, 4095, 1};
  const skyfront_window window = {20, 20, 9, 9}, small = {20, 20, 7, 9};
  skyfront_star star = {.flags = 99};
  is("no frame", skyfront_track_u16(NULL, W, H, W, &camera, &window, 1, NULL, 0, &star), SKYFRONT_ERROR_POINTER);
  is("no camera", skyfront_track_u16(words, W, H, W, NULL, &window, 1, NULL, 0, &star), SKYFRONT_ERROR_POINTER);
  is("no windows", skyfront_track_u16(words, W, H, W, &camera, NULL, 1, NULL, 0, &star), SKYFRONT_ERROR_POINTER);
  is("no bad pixels", skyfront_track_u8(bytes, W, H, W, &camera, &window, 1, NULL, 1, &star), SKYFRONT_ERROR_POINTER);
  is("no room", skyfront_track_u8(bytes, W, H, W, &camera, &window, 1, NULL, 0, NULL), SKYFRONT_ERROR_POINTER);
  is("gain", skyfront_track_u8(bytes, W, H, W, &dark, &window, 1, NULL, 0, &star), SKYFRONT_ERROR_PARAMETER);
  is("window", skyfront_track_u8(bytes, W, H, W, &camera, &small, 1, NULL, 0, &star), SKYFRONT_ERROR_PARAMETER);
  is("size", skyfront_track_u8(bytes, 4, H, W, &camera, &window, 1, NULL, 0, &star), SKYFRONT_ERROR_SIZE);
  is("untouched", star.flags, 99);
  is("nothing to do", skyfront_track_u16(words, W, H, W, &camera, NULL, 0, NULL, 0, NULL), SKYFRONT_OK);
  is("a dark frame", skyfront_track_u8(bytes, W, H, W, &camera, &window, 1, NULL, 0, &star), SKYFRONT_OK);
  is("is lost", star.flags, SKYFRONT_STAR_LOST);
}

static void runs(void)
{
  skyfront_setup setup = {.preset = SKYFRONT_PRESET_PAPER_REAL, .width = W, .height = H, .sources = N};
  skyfront_run *run = NULL;
  skyfront_progress progress;
  skyfront_source source;
  uint32_t labels[W];
  char said[64];
  const size_t all = sizeof memory;
  is("no memory", skyfront_run_start(NULL, all, &setup, &run, NULL, 0), SKYFRONT_ERROR_POINTER);
  is("no setup", skyfront_run_start(memory, all, NULL, &run, NULL, 0), SKYFRONT_ERROR_POINTER);
  is("short memory", skyfront_run_start(memory, all / 2, &setup, &run, said, sizeof said), SKYFRONT_ERROR_LENGTH);
  is("said", strstr(said, "bytes are needed") != NULL, 1);
  setup.preset = 77;
  is("preset", skyfront_run_start(memory, all, &setup, &run, NULL, 0), SKYFRONT_ERROR_PRESET);
  setup.preset = SKYFRONT_PRESET_PAPER_REAL;
  skyfront_setting setting = {"no-such-setting", "1"};
  setup.settings = &setting, setup.setting_count = 1;
  is("setting", skyfront_run_start(memory, all, &setup, &run, NULL, 0), SKYFRONT_ERROR_SETTING);
  setting = (skyfront_setting){"min-area", "many"};
  is("value", skyfront_run_start(memory, all, &setup, &run, said, sizeof said), SKYFRONT_ERROR_SETTING);
  is("said", strcmp(said, "min-area many"), 0);
  setting = (skyfront_setting){"dt", "-1"};
  is("bound", skyfront_run_start(memory, all, &setup, &run, said, sizeof said), SKYFRONT_ERROR_PARAMETER);
  is("said", strncmp(said, "dt is -1; must be above 0", 25), 0);
  setting.name = NULL;
  is("no name", skyfront_run_start(memory, all, &setup, &run, NULL, 0), SKYFRONT_ERROR_POINTER);
  setup.setting_count = 0, setup.width = 2;
  is("width", skyfront_run_start(memory, all, &setup, &run, NULL, 0), SKYFRONT_ERROR_SIZE);
  setup.width = W;
  is("good", skyfront_run_start(memory, all, &setup, &run, NULL, 0), SKYFRONT_OK);
  is("no run", skyfront_run_poll_u16(NULL, 1, words, W, NULL), SKYFRONT_ERROR_POINTER);
  is("stride", skyfront_run_poll_u16(run, 1, words, W - 1, NULL), SKYFRONT_ERROR_LENGTH);
  is("no pixels", skyfront_run_poll_u8(run, 1, NULL, W, NULL), SKYFRONT_ERROR_POINTER);
  is("no function", skyfront_run_poll_rows(run, 1, NULL, NULL, NULL), SKYFRONT_ERROR_POINTER);
  is("refused", skyfront_run_poll_rows(run, 1, refuse, NULL, NULL), SKYFRONT_ERROR_FRAME);
  is("early", skyfront_run_labels(run, 0, labels), SKYFRONT_ERROR_NOT_DONE);
  is("early", skyfront_run_source(run, 0, &source), SKYFRONT_ERROR_NOT_DONE);
  int32_t error = SKYFRONT_OK;
  for (size_t at = 0; at < W * H; at++) {
    bytes[at] = (uint8_t)(at % 7 + (at / W - 10 < 5 && at % W - 20 < 5 ? 150 : 0));
  }
  do {
    error = skyfront_run_poll_u8(run, 5, bytes, W, &progress);
  } while (error == SKYFRONT_OK && !progress.done);
  is("run", error, SKYFRONT_OK);
  is("source", progress.sources, 1);
  is("row", skyfront_run_labels(run, H, labels), SKYFRONT_ERROR_INDEX);
  is("row", skyfront_run_labels(run, 12, labels), SKYFRONT_OK);
  is("label", labels[22], 1);
  is("source", skyfront_run_source(run, 0, &source), SKYFRONT_OK);
  is("column", source.x > 21.5f && source.x < 22.5f, 1);
  is("source", skyfront_run_source(run, 1, &source), SKYFRONT_ERROR_INDEX);
  uint8_t packet[64];
  size_t length = 0;
  skyfront_cursor cursor = {.product = 8};
  is("no cursor", skyfront_packet_labels(NULL, run, packet, 64, &length), SKYFRONT_ERROR_POINTER);
  is("no run", skyfront_packet_labels(&cursor, NULL, packet, 64, &length), SKYFRONT_ERROR_POINTER);
  is("labels", skyfront_packet_labels(&cursor, run, packet, 64, &length), SKYFRONT_OK);
  is("packet", length > 40 && length <= 64 && memcmp(packet, "SkyD", 4) == 0 && packet[8] == 8, 1);
  is("columns", packet[16], W);
}

static void searches(void)
{
  static uint64_t memory[16384], sums[2048];
  const skyfront_camera camera = {64, 2, 7, 4095, 1}, dark = {64, 0, 7, 4095, 1};
  skyfront_search_setup setup = {.pixels_u8 = bytes, .width = W, .height = H, .stride = W, .regions = 100};
  skyfront_search *search = NULL;
  skyfront_search_progress progress = {.done = 0};
  skyfront_measured source;
  char said[96];
  uint32_t done = 0;
  const size_t all = sizeof memory;
  is("room", skyfront_search_bytes(W, H, 100) <= all, 1);
  setup.camera = &dark;
  is("gain", skyfront_search_start(memory, all, &setup, &search, said, sizeof said), SKYFRONT_ERROR_PARAMETER);
  is("said", strncmp(said, "gain is 0; must be at least", 27), 0);
  setup.camera = (const skyfront_camera *)((const char *)&camera + 1);
  is("odd", skyfront_search_start(memory, all, &setup, &search, NULL, 0), SKYFRONT_ERROR_POINTER);
  setup.camera = &camera;
  is("short", skyfront_search_start(memory, all / 4, &setup, &search, NULL, 0), SKYFRONT_ERROR_LENGTH);
  const skyfront_setting filter = {"filter", "median"};
  setup.settings = &filter, setup.setting_count = 1;
  is("filter", skyfront_search_start(memory, all, &setup, &search, said, sizeof said), SKYFRONT_ERROR_FRONT);
  is("said", strstr(said, "in Rust only") != NULL, 1);
  setup.setting_count = 0;
  is("good", skyfront_search_start(memory, all, &setup, &search, NULL, 0), SKYFRONT_OK);
  is("early", skyfront_search_measure_start(search, sums, sizeof sums), SKYFRONT_ERROR_NOT_DONE);
  is("early", skyfront_search_measure(search, 1, &done), SKYFRONT_ERROR_NOT_DONE);
  is("early", skyfront_search_source(search, 0, &source), SKYFRONT_ERROR_NOT_DONE);
  int32_t error = SKYFRONT_OK;
  while (error == SKYFRONT_OK && !progress.done) {
    error = skyfront_search_poll(search, 5, &progress);
  }
  is("run", error, SKYFRONT_OK);
  is("source", progress.sources, 1);
  is("no room", skyfront_search_measure_start(search, NULL, 0), SKYFRONT_ERROR_POINTER);
  is("too little", skyfront_search_measure_start(search, sums, 64), SKYFRONT_ERROR_LENGTH);
  is("enough", skyfront_search_measure_start(search, sums, skyfront_catalogue_bytes(1)), SKYFRONT_OK);
  is("early", skyfront_search_source(search, 0, &source), SKYFRONT_ERROR_NOT_DONE);
  while (error == SKYFRONT_OK && !done) {
    error = skyfront_search_measure(search, 5, &done);
  }
  is("measured", error, SKYFRONT_OK);
  is("source", skyfront_search_source(search, 1, &source), SKYFRONT_ERROR_INDEX);
  is("source", skyfront_search_source(search, 0, NULL), SKYFRONT_ERROR_POINTER);
  is("source", skyfront_search_source(search, 0, &source), SKYFRONT_OK);
  is("place", source.x > 21.5 && source.x < 22.5 && source.y > 11.5 && source.y < 12.5, 1);
  is("light", source.flux > 3000 && source.flux < 5000 && source.flux_error > 0, 1);
}

static void packets(void)
{
  static uint8_t packet[SKYFRONT_PACKET_LEAST_BYTES];
  const skyfront_star star = {.x = 1};
  const skyfront_window window = {20, 20, 8, 8};
  const size_t least = sizeof packet;
  skyfront_cursor cursor = {.product = 8};
  size_t length = 0;
  is("short", skyfront_packet_stars(&cursor, &star, 1, packet, least - 1, &length), SKYFRONT_ERROR_LENGTH);
  is("no stars", skyfront_packet_stars(&cursor, NULL, 1, packet, least, &length), SKYFRONT_ERROR_POINTER);
  is("no room", skyfront_packet_stars(&cursor, &star, 1, NULL, least, &length), SKYFRONT_ERROR_POINTER);
  is("no length", skyfront_packet_stars(&cursor, &star, 1, packet, least, NULL), SKYFRONT_ERROR_POINTER);
  is("not moved", cursor.packet, 0);
  is("stars", skyfront_packet_stars(&cursor, &star, 1, packet, least, &length), SKYFRONT_OK);
  is("length", (long)length, 60);
  is("end", skyfront_packet_stars(&cursor, &star, 1, packet, least, &length), SKYFRONT_OK);
  is("length", (long)length, 0);
  cursor = (skyfront_cursor){.product = 9};
  is("no frame", skyfront_packet_cutouts_u16(&cursor, NULL, W, H, W, &window, 1, packet, least, &length),
     SKYFRONT_ERROR_POINTER);
  is("size", skyfront_packet_cutouts_u8(&cursor, bytes, 2, H, W, &window, 1, packet, least, &length),
     SKYFRONT_ERROR_SIZE);
  is("cut-out", skyfront_packet_cutouts_u8(&cursor, bytes, W, H, W, &window, 1, packet, least, &length), SKYFRONT_OK);
  is("pixels", cursor.pixel, 64 - 16 - 4 - 14 - 4);
}

static void tables(void)
{
  static uint8_t table[4096];
  skyfront_setting setting = {"min-area", "9"};
  skyfront_setup setup = {.preset = SKYFRONT_PRESET_PAPER_F160, .width = W, .height = H, .sources = N,
                          .settings = &setting, .setting_count = 1};
  skyfront_run *run = NULL;
  char said[96];
  const size_t all = skyfront_table_bytes();
  is("room", all <= sizeof table, 1);
  is("short", skyfront_table_write(&setup, table, all - 1, NULL, 0), SKYFRONT_ERROR_LENGTH);
  is("write", skyfront_table_write(&setup, table, all, NULL, 0), SKYFRONT_OK);
  is("check", skyfront_table_check(table, all, NULL, 0), SKYFRONT_OK);
  is("short", skyfront_table_check(table, all - 4, NULL, 0), SKYFRONT_ERROR_LENGTH);
  is("null", skyfront_table_check(NULL, all, NULL, 0), SKYFRONT_ERROR_POINTER);
  skyfront_setup by_table = {.preset = SKYFRONT_PRESET_TABLE, .width = W, .height = H, .sources = N,
                             .table = table, .table_bytes = all};
  is("start", skyfront_run_start(memory, sizeof memory, &by_table, &run, NULL, 0), SKYFRONT_OK);
  table[all / 2] ^= 4;
  is("damaged", skyfront_table_check(table, all, said, sizeof said), SKYFRONT_ERROR_TABLE);
  is("said", strcmp(said, "the parameter table is damaged: its checksum fails"), 0);
  is("refused", skyfront_run_start(memory, sizeof memory, &by_table, &run, NULL, 0), SKYFRONT_ERROR_TABLE);
  setting.value = "0";
  is("bound", skyfront_table_write(&setup, table, all, said, sizeof said), SKYFRONT_ERROR_PARAMETER);
  is("said", strcmp(said, "min-area is 0; must be at least 1"), 0);
}

static void sizes(void)
{
  static const size_t sides[] = {8, 31, 100, 512, 1024, 4099};
  for (size_t i = 0; i < 6; i++) {
    for (size_t j = 0; j < 6; j++) {
      size_t needed = skyfront_run_bytes(sides[i], sides[j], 40);
      size_t constant = SKYFRONT_RUN_BYTES(sides[i], sides[j], 40);
      is("the constant is enough", needed > 0 && needed <= constant, 1);
      is("and not much too much", constant < needed + needed / 8 + 8192, 1);
    }
  }
  is("too much to be counted", (long)skyfront_run_bytes((size_t)-1, 2, 3), 0);
}

int main(void)
{
  windows();
  runs();
  searches();
  packets();
  tables();
  sizes();
  is("the standard's check value", skyfront_crc32((const uint8_t *)"123456789", 9) == UINT32_C(0xCBF43926), 1);
  is("text", strcmp(skyfront_error_text(SKYFRONT_ERROR_PRESET), "there is no preset of this number"), 0);
  if (failures == 0) {
    printf("done\n");
  }
  return failures != 0;
}
