/* SweeperC: a simulated ladar in C, as python/examples/sweeper.py is one in Python. */
#include <stdint.h>

#include "rack.h"

enum { kLadar = 20, kPoints = 181 };

/* The body of LadarData (rack/proxies/ladar.h): its fields are its layout. */
struct ladar_data {
  uint32_t recordingTime; /* ms */
  uint32_t duration;      /* ms */
  int32_t maxRange;       /* mm */
  float startAngle;       /* rad, clockwise */
  float endAngle;
  int32_t pointNum;
  struct {
    float angle;
    int32_t distance; /* mm */
    int32_t type;
    int32_t intensity;
  } points[kPoints];
};

static const struct rack_parameter kParameters[] = {
    {.name = "period",
     .help = "period of the data [ms]",
     .takes_effect = RACK_AT_ON,
     .number = 100,
     .min = 10,
     .max = 60000},
    {.name = "radius",
     .help = "radius of the room [mm]",
     .takes_effect = RACK_NOW,
     .number = 3000,
     .min = 100,
     .max = 30000},
};

static int turn_on(rack_module* module, void* user) {
  (void)user;
  rack_set_period(module, (uint32_t)rack_integer(module, "period"));
  return 0;
}

static int loop(rack_module* module, void* user) {
  struct ladar_data* scan = user;
  rack_sleep_until_next(module);
  const int32_t radius = rack_integer(module, "radius");
  for (int i = 0; i < kPoints; ++i) {
    scan->points[i].angle = (float)((i - 90) * 3.14159265358979 / 180);
    scan->points[i].distance = radius;
  }
  scan->recordingTime = rack_time_stamp();
  scan->duration = rack_period(module);
  scan->startAngle = scan->points[0].angle;
  scan->endAngle = scan->points[kPoints - 1].angle;
  return rack_publish(module, scan->recordingTime, scan, sizeof *scan);
}

static int command(rack_module* module, const struct tims_header* header, const void* body,
                   size_t size, void* user) {
  (void)header, (void)body, (void)size, (void)user;
  return rack_unknown_command(module); /* a ladar has none of its own */
}

int main(int argc, char** argv) {
  struct ladar_data scan = {.maxRange = 30000, .pointNum = kPoints};
  const struct rack_component sweeper = {
      .program = "SweeperC",
      .purpose = "Scans a round room.",
      .class_id = kLadar,
      .parameters = kParameters,
      .parameter_count = sizeof kParameters / sizeof *kParameters,
      .data_max = sizeof scan,
      .user = &scan,
      .on = turn_on,
      .loop = loop,
      .command = command,
  };
  return rack_run(&sweeper, argc, argv);
}
