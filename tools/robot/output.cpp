#include "tools/robot/output.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

namespace timsctl::robot {

ProgramOutput::ProgramOutput(tims::os::File pipe) : pipe_(std::move(pipe)) {
  ::fcntl(pipe_.get(), F_SETFL, O_NONBLOCK);
}

int ProgramOutput::descriptor(tims::Time now) const {
  return now < rests_until_ ? -1 : pipe_.get();
}

void ProgramOutput::read(tims::Time now, FloodGate& gate, std::vector<std::string>& lines) {
  std::array<char, kReadPerTurn> text{};
  if (descriptor(now) < 0) return;
  const ssize_t n = ::read(pipe_.get(), text.data(), text.size());
  if (n > 0) take({text.data(), static_cast<std::size_t>(n)}, now, gate, lines);
  if (n == std::ssize(text) || (n > 0 && gate.is_cut())) rests_until_ = now + kReadPause;
  if (n != 0) return;
  pipe_.reset();  // all writers have closed it
  if (!rest_.empty() && gate.pass(now)) lines.push_back(std::exchange(rest_, {}));
}

// While the gate is closed, lines are only counted.
void ProgramOutput::take(std::string_view text, tims::Time now, FloodGate& gate,
                         std::vector<std::string>& lines) {
  if (gate.is_cut()) {
    const auto ends = static_cast<std::uint64_t>(std::ranges::count(text, '\n'));
    (void)gate.pass(now, ends + text.size() / kLineMax);
    rest_.clear();
    return;
  }
  std::vector<std::string> more = split(text);
  more.resize(static_cast<std::size_t>(gate.pass(now, more.size())));
  lines.insert(lines.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
}

// The completed lines, without their ends.
std::vector<std::string> ProgramOutput::split(std::string_view text) {
  std::vector<std::string> lines;
  for (const char c : text) {
    if (c != '\n') rest_ += c;
    if (c == '\n' || rest_.size() == kLineMax) lines.push_back(std::exchange(rest_, {}));
  }
  return lines;
}

}  // namespace timsctl::robot
