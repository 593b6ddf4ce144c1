#include "tests/bench/robot_start.h"

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "libtims/os/clock.h"
#include "tests/bench/launch.h"
#include "tests/bench/metrics.h"

namespace tims::bench {
namespace {

struct Part {
  const char* program;
  int instance;
  const char* parameters;
  const char* address;
};

// Components that can be on at the same time, producers before their consumers.
constexpr Part kParts[] = {
    {"ChassisSim", 0, "periodTime = 20", "Chassis/0/0"},
    {"ChassisSim", 1, "periodTime = 20", "Chassis/0/1"},
    {"OdometryChassis", 0, "", "Odometry/0/0"},
    {"OdometryChassis", 1, "chassisInst = 1", "Odometry/0/1"},
    {"Position", 0, "", "Position/0/0"},
    {"Position", 1, "odometryInst = 1", "Position/0/1"},
    {"Scan2dSim", 0, "mapFile = 'floor.dxf'", "Scan2d/0/0"},
    {"Scan2dSim", 1, "mapFile = 'floor.dxf', odometryInst = 1", "Scan2d/0/1"},
    {"LadarSim", 0, "mapFile = 'floor.dxf'", "Ladar/0/0"},
    {"LadarSim", 1, "mapFile = 'floor.dxf'", "Ladar/0/1"},
    {"Scan2d", 2, "ladarInst = 0, positionInst = 0", "Scan2d/0/2"},
    {"ClockSystem", 0, "", "Clock/0/0"},
};

// A room of 10 m x 10 m.
constexpr const char* kFloor =
    "0\nSECTION\n2\nENTITIES\n"
    "0\nLINE\n10\n-5\n20\n-5\n11\n5\n21\n-5\n"
    "0\nLINE\n10\n5\n20\n-5\n11\n5\n21\n5\n"
    "0\nLINE\n10\n5\n20\n5\n11\n-5\n21\n5\n"
    "0\nLINE\n10\n-5\n20\n5\n11\n-5\n21\n-5\n"
    "0\nENDSEC\n0\nEOF\n";

std::string robot_file() {
  std::string text = "name = \"bench\"\n";
  for (const Part& part : kParts)
    text += std::string("[[component]]\nprogram = \"") + part.program +
            "\"\ninstance = " + std::to_string(part.instance) + "\nparameters = { " +
            part.parameters + " }\n";
  return text;
}

}  // namespace

bool start_robot(const Plan& plan) {
  const std::string timsctl =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename("timsctl");
  std::ofstream(plan.folder + "/floor.dxf") << kFloor;
  std::ofstream(plan.folder + "/robot.toml") << robot_file();
  const Time start = os::now();
  const std::string host = "--host=unix:" + plan.socket;
  auto up = launch({timsctl, host, "up", plan.folder + "/robot.toml"}, false);
  std::vector<std::string> on{timsctl, host, "component", "on", "--wait"};
  for (const Part& part : kParts) on.emplace_back(part.address);
  auto all = launch(on, false);
  if (!up || !all) return false;
  const auto ended = all->wait(kStartLimit);
  const Duration took = os::now() - start;
  const auto down = up->stop(SIGTERM);
  if (!ended || !ended->success() || !down || !down->success()) {
    std::fprintf(stderr, "robot: %s%s", all->output().c_str(), up->output().c_str());
    return false;
  }
  print_metric("on_s", std::chrono::duration<double>(took).count());
  return true;
}

}  // namespace tims::bench
