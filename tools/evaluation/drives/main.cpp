// rack-drives: goal drives of a simulated robot in simulated time, thousands in a minute.
#include <algorithm>
#include <map>
#include <string>

#include <fmt/format.h>

#include "base/text.h"
#include "components/files/whole_file.h"
#include "tools/cli/argument_parser.h"
#include "tools/cli/failure.h"
#include "tools/evaluation/drives/drive.h"
#include "tools/evaluation/drives/scene_file.h"

namespace rack::drives {
namespace {

using timsctl::Exit;
using timsctl::Failure;

struct Arguments {
  std::string world;
  std::string plan;
  std::uint64_t seed = 1;
  std::uint64_t count = 100;
  double stalls = 0;
  double longest = 0.5;
  double crashes = 0;
  double lost = 0;
  std::string svg;
  bool anywhere = false;
  bool goals = false;
};

std::string_view name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::kArrived:
      return "arrived";
    case Outcome::kNoPath:
      return "no path";
    case Outcome::kGaveUp:
      return "gave up";
  }
  return "";
}

void print(std::uint64_t seed, const DriveResult& result) {
  fmt::print(
      "{:>8}  {:<8} {:6.1f} s  {:5.2f} m off  {} contacts  certain within {:.2f} m, {:.0f} "
      "deg  ({:.1f}, {:.1f}) to ({:.1f}, {:.1f})  {}\n",
      seed, name_of(result.outcome), result.seconds, result.off_goal / 1000, result.contacts,
      result.wrong_while_certain / 1000, degrees(result.turned_while_certain),
      result.start.x / 1000, result.start.y / 1000, result.goal.x / 1000, result.goal.y / 1000,
      result.why);
}

// For drives of real programs to the goals of the same seed (tools/evaluation/goals).
Exit list_goals(const Course& course, const Arguments& arguments) {
  Random random(arguments.seed);
  for (std::uint64_t i = 0; i < arguments.count; ++i) {
    const Pose goal = course.draw_goal(random);
    fmt::print("{:.2f} {:.2f} {:.0f}\n", goal.x / 1000, goal.y / 1000, degrees(goal.rho));
  }
  return Exit::kDone;
}

Exit run(const Arguments& arguments) {
  auto scene = read_scene(arguments.world, arguments.plan);
  if (!scene) throw Failure(Exit::kUsage, "bad_scene", scene.error().detail());
  auto course = Course::make(std::move(*scene));
  if (!course) throw Failure(Exit::kUsage, "bad_scene", course.error().detail());
  if (arguments.goals) return list_goals(*course, arguments);
  const Load load{.stalls_per_second = arguments.stalls,
                  .longest_stall = std::chrono::duration_cast<tims::Duration>(
                      std::chrono::duration<double>(arguments.longest)),
                  .crashes_per_minute = arguments.crashes,
                  .lost_share = arguments.lost};
  if (!arguments.svg.empty()) {
    const DriveResult result = course->drive({.seed = arguments.seed,
                                              .load = load,
                                              .starts_anywhere = arguments.anywhere,
                                              .records = true});
    print(arguments.seed, result);
    for (const std::string& line : result.log) fmt::print("{}\n", line);
    if (auto written = write_file(arguments.svg, plot::to_svg(result.picture)); !written)
      throw Failure(Exit::kDenied, "not_written", written.error().detail());
    return result.holds() ? Exit::kDone : Exit::kNo;
  }
  std::map<std::string, std::uint64_t> sums;
  for (std::uint64_t seed = arguments.seed; seed < arguments.seed + arguments.count; ++seed) {
    const DriveResult result =
        course->drive({.seed = seed, .load = load, .starts_anywhere = arguments.anywhere});
    ++sums[std::string(name_of(result.outcome))];
    if (result.contacts > 0) ++sums["with contacts"];
    if (result.was_certain_of_a_wrong_place()) ++sums["certain of a wrong place"];
    if (!result.holds() || result.outcome != Outcome::kArrived) print(seed, result);
  }
  for (const auto& [name, sum] : sums) fmt::print("{}: {} of {}\n", name, sum, arguments.count);
  return sums["arrived"] * 100 >= arguments.count * 99 && sums["with contacts"] == 0 &&
                 sums["certain of a wrong place"] == 0
             ? Exit::kDone
             : Exit::kNo;
}

}  // namespace
}  // namespace rack::drives

int main(int argc, char** argv) {
  using namespace rack::drives;
  Arguments arguments;
  timsctl::ArgumentParser parser(
      "rack-drives",
      "Sends a simulated robot to random goals, in simulated time, with programs that wait, crash, "
      "and lose messages.\nThe same seed gives the same drive. The exit status is 0 if 99 % arrive "
      "without a contact of their own, and\nnone was certain of a wrong place.",
      "  rack-drives deploy/worlds/floor.toml deploy/robots/floor.dxf --count 500 --stalls 0.5\n"
      "  rack-drives deploy/worlds/floor.toml deploy/robots/floor.dxf --seed 17 --svg drive.svg");
  parser.required_argument("WORLD", arguments.world, "world with a robot (TOML)");
  parser.required_argument("PLAN", arguments.plan,
                           "plan by which the robot drives: DXF, or a map of ROS (.yaml)");
  parser.option("--seed", arguments.seed, "seed of the first drive");
  parser.option("--count", arguments.count, "number of drives", {.min = 1, .max = 1e7});
  parser.option("--stalls", arguments.stalls, "stalls of each program per second",
                {.min = 0, .max = 100});
  parser.option("--longest-stall", arguments.longest, "length of the longest stall [s]",
                {.min = 0, .max = 60});
  parser.option("--crashes", arguments.crashes, "crashed programs per minute",
                {.min = 0, .max = 60});
  parser.option("--lost", arguments.lost, "share of chassis data and scans that get lost",
                {.min = 0, .max = 1});
  parser.flag("--anywhere", arguments.anywhere,
              "start at a random place, which the robot has to find in its map");
  parser.flag("--goals", arguments.goals, "list COUNT goals [m, m, deg] instead of driving");
  parser.option("--svg", arguments.svg, "drive once, print its log, and draw it to this file");
  return parser.run(argc, argv, [&] { return run(arguments); });
}
