// tims-replay: replays a recorded session against a router and compares every answer.
#include <csignal>
#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>
#include <boost/json.hpp>
#include <sys/signalfd.h>

#include "os/file.h"
#include "tests/support/recording.h"
#include "tests/support/replay.h"

namespace {

using tims::test::Difference;
using tims::test::Recording;
using tims::test::ReplayEnd;
using tims::test::ReplayOptions;
using tims::test::ReplayResult;

enum ExitCode { kSame = 0, kDifferent = 1, kCannot = 2, kInterrupted = 130 };

struct CommandLine {
  std::string file;
  bool json = false;
  ReplayOptions replay;
};

constexpr const char* kHelp =
    "Replays a recorded session of original RACK programs against a router, over TCP, and\n"
    "compares everything the router delivers.";

constexpr const char* kFooter =
    "Recordings and their format: tests/data/recordings/. The third one (c-disturbances) needs a\n"
    "router with tcp.compat_delete = true and message.max = \"256KiB\"; it is replayed up to its\n"
    "mark K1, where the router would have to be restarted.\n"
    "\n"
    "Examples:\n"
    "  tims-replay tests/data/recordings/a-gui-drive.jsonl.gz --to 127.0.0.1:2000\n"
    "  tims-replay session.jsonl.gz --to robot:2000 --pace 1     as fast as it was recorded\n"
    "\n"
    "Exit status: 0 no difference, 1 differences, 2 could not replay, 130 interrupted.";

// SIGINT and SIGTERM make this readable instead of ending the program, so connections are closed.
tims::os::File catch_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, number);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return tims::os::File(::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
}

void add_options(CLI::App& app, CommandLine& c) {
  app.footer(kFooter);
  app.add_option("FILE", c.file, "recording (*.jsonl.gz)")->required();
  app.add_option("--to", c.replay.endpoint, "address of the router (host:port)")
      ->required()
      ->type_name("HOST:PORT");
  app.add_option("--pace", c.replay.pace,
                 "speed factor: 1 keeps the recorded times, 10 is ten times as fast; default: "
                 "as fast as possible")
      ->check([](const std::string& text) {
        double pace = 0;
        const bool good = CLI::detail::lexical_cast(text, pace) && pace > 0;
        return good ? "" : "\"" + text + "\" is not a number above 0";
      })
      ->type_name("X");
  app.add_option(
         "--message-max", c.replay.message_max,
         "largest message that this router accepts, e.g. 16MiB; recorded messages that were "
         "too long for the original router, but not for this one, are skipped")
      ->transform(CLI::AsSizeValue(false))
      ->type_name("SIZE");
  app.add_flag("--json", c.json, "print the result as one JSON object, and nothing else");
}

void show_marks(CommandLine& c) {
  if (c.json) return;
  c.replay.on_mark = [](const tims::test::recorded::Line& line) {
    const double seconds = static_cast<double>(line.time.count()) / 1e6;
    const auto& mark = std::get<tims::test::recorded::Mark>(line.event);
    std::printf("%7.1f s  %s\n", seconds, mark.text.c_str());
    std::fflush(stdout);
  };
}

boost::json::object to_json(const Difference& d) {
  return {{"line", d.line},
          {"connection", d.conn},
          {"peer", d.peer},
          {"expected", d.expected},
          {"got", d.got}};
}

boost::json::object to_json(const ReplayResult& r) {
  boost::json::array differences;
  for (const Difference& d : r.differences) differences.push_back(to_json(d));
  return {{"same", r.same()},
          {"complete", r.end == ReplayEnd::kComplete},
          {"end_reason", r.end_reason},
          {"lines", r.lines},
          {"connections", r.connections},
          {"sent", r.sent},
          {"received_as_expected", r.received_as_expected},
          {"lifesigns_answered", r.lifesigns_answered},
          {"left_out", r.left_out},
          {"took_ns", r.took.count()},
          {"differences", std::move(differences)}};
}

void show_result(const ReplayResult& result, bool json) {
  if (json) {
    std::puts(boost::json::serialize(to_json(result)).c_str());
    return;
  }
  for (const Difference& d : result.differences) std::puts(d.to_string().c_str());
  std::puts(result.summary().c_str());
}

ExitCode exit_code(const ReplayResult& result) {
  if (!result.same()) return kDifferent;
  switch (result.end) {
    case ReplayEnd::kComplete:
    case ReplayEnd::kNeedsRestart:
      return kSame;
    case ReplayEnd::kStopped:
      return kInterrupted;
    case ReplayEnd::kGaveUp:
      break;
  }
  return kCannot;
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine command_line;
  CLI::App app(kHelp, "tims-replay");
  add_options(app, command_line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e) == 0 ? kSame : kCannot;
    const auto extra = app.remaining();
    const std::string what =
        extra.empty() ? e.what() : "unknown option or argument " + extra.front();
    std::fprintf(stderr, "tims-replay: %s\n  -> tims-replay --help\n", what.c_str());
    return kCannot;
  }
  const auto recording = tims::test::read_recording(command_line.file);
  if (!recording) {
    std::fprintf(stderr, "tims-replay: %s\n", recording.error().message().c_str());
    return kCannot;
  }
  const tims::os::File signals = catch_signals();
  command_line.replay.stop_fd = signals.get();
  show_marks(command_line);
  const ReplayResult result = tims::test::replay(*recording, command_line.replay);
  show_result(result, command_line.json);
  return exit_code(result);
}
