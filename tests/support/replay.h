// Replays a recorded session against a router over real TCP connections and compares every reply.
//
// The rules of the replay and of the comparison are in tests/data/recordings/README.md. In short:
// the messages of the programs are sent again, each as soon as everything that the recording shows
// before it has arrived; each connection must receive exactly what it received in the recording.
// Lifesigns of the router under test are answered, except on connections that stop answering in the
// recording.
//
// In addition to the recorded mailboxes every connection registers 0x7E000000 + its number. A
// message from there to itself returns when the router has processed everything before it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/patience.h"
#include "tests/support/recording.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::test {

struct ReplayOptions {
  std::string endpoint;  // address of the router, host:port

  // Called at mark K1 of the third recording: kills the router and starts one that accepts messages
  // of 1 MiB; returns its endpoint. Without it the replay ends at this mark.
  std::function<Result<std::string>()> restart{};

  // The largest message the router accepts, if it is more than in the recording: recorded messages
  // that were too long and would pass now are skipped. 0: the same limit as recorded.
  std::uint32_t message_max = 0;

  // 0: as fast as possible. Otherwise the speed factor: 1 keeps the recorded times, 10 is ten times
  // as fast.
  double pace = 0;

  Duration answer_limit = kPatience / 2;  // for everything that should happen immediately
  Duration silence_limit = kPatience;     // for the router to close clients that do not answer
  std::size_t differences_max = 25;       // then the replay is aborted

  int stop_fd = -1;  // the replay ends when this becomes readable
  std::function<void(const recorded::Line&)> on_mark{};
};

struct Difference {
  int line = 0;  // of the recording
  int conn = -1;
  std::string peer;
  std::string expected;
  std::string got;

  // "line 2034, connection 18 (bob): expected ..., got ..."
  [[nodiscard]] std::string to_string() const;
};

enum class ReplayEnd {
  kComplete,
  kNeedsRestart,  // at mark K1, without ReplayOptions::restart
  kStopped,       // by ReplayOptions::stop_fd
  kGaveUp,        // no router, or too many differences
};

struct ReplayResult {
  std::vector<Difference> differences;
  ReplayEnd end = ReplayEnd::kComplete;
  std::string end_reason;  // unless it is complete

  int lines = 0;  // replayed
  int connections = 0;
  std::uint64_t sent = 0;  // messages, without answers to lifesigns
  std::uint64_t received_as_expected = 0;
  std::uint64_t lifesigns_answered = 0;
  int left_out = 0;  // recorded as too long, but accepted by this router
  Duration took{0};

  [[nodiscard]] bool same() const { return differences.empty(); }
  [[nodiscard]] std::string summary() const;  // one line
};

ReplayResult replay(const Recording& recording, const ReplayOptions& options);

}  // namespace tims::test
