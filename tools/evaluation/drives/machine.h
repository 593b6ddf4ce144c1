// The machine that a simulated robot's programs run on: when each of them gets to run. Pure.
//
// A busy machine lets programs wait: from time to time each one does not run for a while. Messages
// wait meanwhile, up to the places of a mailbox; who asks a waiting program gets no answer in time.
// Programs may also end and be restarted by the supervisor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "components/geometry/random.h"
#include "tims/time.h"

namespace rack::drives {

enum class Program : std::uint8_t { kChassis, kScan2d, kOdometry, kPosition, kMcl, kPath, kPilot };
inline constexpr std::size_t kPrograms = 7;

struct Load {
  double stalls_per_second = 0;                             // of each program
  tims::Duration longest_stall{};                           // they last from nothing to this
  double crashes_per_minute = 0;                            // of the whole robot
  double lost_share = 0;                                    // of messages
  tims::Duration restart = std::chrono::milliseconds(600);  // from a crash until it is ready
};

class Machine {
 public:
  Machine(const Load& load, std::uint64_t seed) : load_(load), random_(seed) {}

  // Draws what happens in the next `step`.
  void advance(tims::Time now, tims::Duration step);
  [[nodiscard]] bool runs(Program program, tims::Time now) const {
    return now >= waits_until_[index(program)];
  }
  // Whether it has ended since the last call: its state is lost.
  bool take_crash(Program program);
  // Whether a message gets lost.
  bool loses() { return random_.uniform() < static_cast<float>(load_.lost_share); }

 private:
  static std::size_t index(Program program) { return static_cast<std::size_t>(program); }

  Load load_;
  Random random_;
  std::array<tims::Time, kPrograms> waits_until_{};
  std::array<bool, kPrograms> has_crashed_{};
};

}  // namespace rack::drives
