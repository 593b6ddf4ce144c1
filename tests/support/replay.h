// Replays a recorded session against a router over real TCP connections and compares every reply.
//
// How it is replayed and what must match is written in tests/data/recordings/README.md. In short:
// what the programs sent is sent again, as soon as everything has come that the recording shows
// before it; each connection receives what it received then, no more and no less. Lifesigns of the
// router under test are answered, except by connections that the recording shows to fall silent.
//
// Beside the recorded mailboxes every connection registers one more, 0x7E000000 + its number: a
// message from there to itself comes back when the router has taken everything before it.
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
  std::string endpoint;  // of the router, host:port

  // Called at mark K1 of the third recording: kills the router and starts one that takes messages
  // of 1 MiB; returns its endpoint. Without it the replay ends at this mark.
  std::function<Result<std::string>()> restart{};

  // Largest message the router takes, where that is more than the recorded one took: too long
  // messages that would pass are left out. 0: the same limits as recorded.
  std::uint32_t message_max = 0;

  // 0: as fast as possible. Else the speed of time: 1 keeps the recorded moments, 10 is ten times
  // as fast.
  double pace = 0;

  Duration answer_limit = kPatience / 2;  // for everything that should happen at once
  Duration silence_limit = kPatience;     // for the router to close silent clients
  std::size_t differences_max = 25;       // then it gives up

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
  std::string end_reason;  // where it is not complete

  int lines = 0;  // replayed
  int connections = 0;
  std::uint64_t sent = 0;  // messages, without answers to lifesigns
  std::uint64_t received_as_expected = 0;
  std::uint64_t lifesigns_answered = 0;
  int left_out = 0;  // too long messages that this router takes
  Duration took{0};

  [[nodiscard]] bool same() const { return differences.empty(); }
  [[nodiscard]] std::string summary() const;  // one line
};

ReplayResult replay(const Recording& recording, const ReplayOptions& options);

}  // namespace tims::test
