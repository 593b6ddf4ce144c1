// The output of a program: its pipe, read in bounded pieces, split into lines, and cut when it is a
// flood.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "os/file.h"
#include "tims/time.h"
#include "tools/robot/flood_gate.h"

namespace timsctl::robot {

inline constexpr std::size_t kLineMax = 4096;  // a longer line is split

// At most this much is read in one turn of the supervisor. After a turn with so much, the pipe
// rests: a program that prints faster waits in its write.
inline constexpr std::size_t kReadPerTurn = 16 << 10;
inline constexpr tims::Duration kReadPause = std::chrono::milliseconds(20);

class ProgramOutput {
 public:
  ProgramOutput() = default;
  // `pipe`: its reading end.
  explicit ProgramOutput(tims::os::File pipe);

  // Appends the lines that have arrived and pass the gate.
  void read(tims::Time now, FloodGate& gate, std::vector<std::string>& lines);
  // To be watched for input; -1: it is closed, or rests until rests_until().
  [[nodiscard]] int descriptor(tims::Time now) const;
  [[nodiscard]] tims::Time rests_until() const { return pipe_ ? rests_until_ : tims::kNever; }

 private:
  void take(std::string_view text, tims::Time now, FloodGate& gate,
            std::vector<std::string>& lines);
  std::vector<std::string> split(std::string_view text);

  tims::os::File pipe_;
  std::string rest_;  // the last line, without its end
  tims::Time rests_until_{};
};

}  // namespace timsctl::robot
