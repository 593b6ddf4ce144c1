// pilot-replay: replays the recording of a pilot: prints why it stopped, and checks that the
// decisions are identical.
#include <cstdio>
#include <optional>

#include <boost/json.hpp>
#include <fmt/core.h>

#include "base/text.h"
#include "components/pilot/pilot_replay.h"
#include "rack/devices/recording.h"
#include "tools/cli/argument_parser.h"

namespace rack::pilot {
namespace {

using timsctl::Exit;
using timsctl::Failure;

constexpr const char* kAbout =
    "Replay the decisions of PilotPath from a recording (PilotPath --record=FILE), at once and\n"
    "without a robot. Each MOVE must be identical, bit for bit; the first difference is printed\n"
    "with the input of the decision.";
constexpr const char* kExamples =
    "Examples:\n"
    "  pilot-replay drive.cap --why                  print each stop with its reason\n"
    "  pilot-replay drive.cap --set maxSpeed=2000    find where another value changes a decision\n"
    "\n"
    "Exit status: 0 all decisions are identical, 1 some differ or parts of the recording are "
    "missing,\n"
    "2 wrong command line, 4 no such file.";

struct Wanted {
  std::string file;
  std::vector<std::string> changes;
  bool why = false;
  bool json = false;
};

double seconds(tims::Duration time) { return std::chrono::duration<double>(time).count(); }

void change(PilotReplay& replay, const std::string& text) {
  const std::size_t mark = text.find('=');
  const auto value = mark == std::string::npos
                         ? std::nullopt
                         : tims::base::parse_number<i32>(std::string_view(text).substr(mark + 1));
  if (!value)
    throw Failure(Exit::kUsage, "usage",
                  fmt::format("--set {}: expected NAME=NUMBER, such as maxSpeed=2000", text));
  if (auto good = replay.change(text.substr(0, mark), *value); !good)
    throw Failure(Exit::kUsage, "usage", "--set: " + good.error().detail());
}

// Returns the number of unreadable lines.
std::uint64_t play(const std::string& file, PilotReplay& replay) {
  const auto read = device::read_recording(
      file, [&](const device::CaptureRecord& record) { return replay.take(record); });
  if (read) return *read;
  if (read.error().code() == tims::Errc::kSystem)
    throw Failure(Exit::kNoSuch, "no_such_file", read.error().detail());
  throw Failure(Exit::kNo, "bad_file", read.error().detail(),
                "was it recorded by PilotPath --record=FILE?");
}

void print_text(const PilotReplay& replay, const Wanted& wanted) {
  if (wanted.why) {
    for (const PilotReplay::Event& event : replay.events())
      fmt::print("{:10.3f} s  at {:.2f} {:.2f} m  {}: {}\n", seconds(event.at), event.pose.x / 1000,
                 event.pose.y / 1000, event.stops ? "stops" : "drives", event.why);
  }
  if (const auto& first = replay.first_difference())
    fmt::print("{:10.3f} s  {}\n", seconds(first->at), first->text);
  fmt::print("{} decisions: {} different", replay.decisions(), replay.different());
  if (replay.undecided() > 0)
    fmt::print("; {} more cannot be reproduced: earlier records are missing", replay.undecided());
  fmt::print("\n");
}

void print_json(const PilotReplay& replay, std::uint64_t unreadable) {
  boost::json::array events;
  for (const PilotReplay::Event& event : replay.events())
    events.push_back({{"s", seconds(event.at)},
                      {"x_m", event.pose.x / 1000},
                      {"y_m", event.pose.y / 1000},
                      {"stands", event.stops},
                      {"why", event.why}});
  boost::json::object all{{"begins", replay.begins()},       {"decisions", replay.decisions()},
                          {"different", replay.different()}, {"undecided", replay.undecided()},
                          {"unreadable_lines", unreadable},  {"events", std::move(events)}};
  if (const auto& first = replay.first_difference())
    all["first_difference"] = {{"s", seconds(first->at)}, {"text", first->text}};
  fmt::print("{}\n", boost::json::serialize(all));
}

Exit run(const Wanted& wanted) {
  PilotReplay replay;
  for (const std::string& text : wanted.changes) change(replay, text);
  const std::uint64_t unreadable = play(wanted.file, replay);
  if (replay.begins() == 0)
    throw Failure(Exit::kNo, "bad_file", wanted.file + ": it does not contain the ON of a pilot",
                  "record it with PilotPath --record=FILE");
  if (wanted.json)
    print_json(replay, unreadable);
  else
    print_text(replay, wanted);
  return replay.different() + replay.undecided() == 0 ? Exit::kDone : Exit::kNo;
}

}  // namespace
}  // namespace rack::pilot

int main(int argc, char** argv) {
  using namespace rack::pilot;
  Wanted wanted;
  timsctl::ArgumentParser parser("pilot-replay", kAbout, kExamples);
  parser.required_argument("FILE", wanted.file, "recording by PilotPath --record=FILE");
  parser.flag("--why", wanted.why,
              "print each time it stopped or started to drive, with the reason");
  parser.option("--set", "NAME=NUMBER", wanted.changes,
                "use another value of a parameter: " + PilotReplay::changeable());
  parser.flag("--json", wanted.json, "print one JSON object");
  return parser.run(argc, argv, [&] { return run(wanted); });
}
