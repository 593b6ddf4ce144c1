/* SweeperC: a simulated ladar in C, as python/examples/sweeper.py is one in Python. */
#include <rack_messages.h>
#include <stdint.h>

#include "rack.h"

enum { kPoints = 181 };

struct sweeper {
  struct rack_LadarPoint points[kPoints];
  uint8_t body[RACK_BODY_MAX_LadarData];
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
  struct sweeper* sweeper = user;
  struct rack_LadarData scan;
  struct rack_problem problem;
  rack_sleep_until_next(module);
  const int32_t radius = rack_integer(module, "radius"); /* mm */
  for (int i = 0; i < kPoints; ++i) {
    sweeper->points[i].angle = (float)((i - 90) * 3.14159265358979 / 180); /* rad, clockwise */
    sweeper->points[i].distance = radius;
  }
  rack_init_LadarData(&scan);
  scan.recordingTime = rack_time_stamp();
  scan.duration = rack_period(module);
  scan.maxRange = 30000;
  scan.startAngle = sweeper->points[0].angle;
  scan.endAngle = sweeper->points[kPoints - 1].angle;
  scan.pointNum = kPoints;
  scan.points = sweeper->points;
  const int64_t size =
      rack_encode_LadarData(&scan, RACK_NATIVE, sweeper->body, sizeof sweeper->body, &problem);
  if (size < 0) return rack_fail(module, (int)size, problem.text);
  return rack_publish(module, scan.recordingTime, sweeper->body, (size_t)size);
}

static int command(rack_module* module, const struct tims_header* header, const void* body,
                   size_t size, void* user) {
  (void)header, (void)body, (void)size, (void)user;
  return rack_unknown_command(module); /* a ladar has none of its own */
}

int main(int argc, char** argv) {
  static struct sweeper state;
  const struct rack_component sweeper = {
      .program = "SweeperC",
      .purpose = "Scans a round room.",
      .class_id = RACK_CLASS_LADAR,
      .parameters = kParameters,
      .parameter_count = sizeof kParameters / sizeof *kParameters,
      .data_max = sizeof state.body,
      .user = &state,
      .on = turn_on,
      .loop = loop,
      .command = command,
  };
  return rack_run(&sweeper, argc, argv);
}
