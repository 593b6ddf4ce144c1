#include "tools/robot/output.h"

#include <algorithm>
#include <array>
#include <iterator>

#include <fcntl.h>
#include <unistd.h>

namespace timsctl::robot {

std::vector<std::string> LineBuffer::add(std::string_view text) {
  std::vector<std::string> lines;
  for (const char c : text) {
    if (c != '\n') rest_ += c;
    if (c == '\n' || rest_.size() == kLineMax) lines.push_back(take_rest());
  }
  return lines;
}

// --- FloodGate

std::uint64_t FloodGate::pass(tims::Time now, std::uint64_t lines) {
  if (cut_) measure(now);
  std::uint64_t passed = 0;
  while (!cut_ && passed < lines) {
    if (limiter_.take(now)) {
      ++passed;
    } else {
      cut_ = true;
      cut_at_ = second_ = now;
      in_second_ = 0;
    }
  }
  held_back_ += lines - passed;
  in_second_ += lines - passed;
  return passed;
}

// The gate opens after a second with few lines.
void FloodGate::measure(tims::Time now) {
  if (now - second_ < std::chrono::seconds(1)) return;
  const bool long_ago = now - second_ >= std::chrono::seconds(2);
  cut_ = !long_ago && in_second_ > kLinesPerSecond;
  second_ = now;
  in_second_ = 0;
}

std::optional<std::uint64_t> FloodGate::take_report(tims::Time now) {
  if (cut_) measure(now);
  if (now < report_at()) return std::nullopt;
  reported_ = now;
  return std::exchange(held_back_, 0);
}

tims::Time FloodGate::report_at() const {
  if (held_back_ == 0) return tims::kNever;
  return std::max(reported_ + kFloodReportEach, cut_at_ + std::chrono::seconds(1));
}

// --- ProgramOutput

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
  if (std::string rest = buffer_.take_rest(); !rest.empty() && gate.pass(now))
    lines.push_back(std::move(rest));
}

// While the gate is closed, lines are only counted.
void ProgramOutput::take(std::string_view text, tims::Time now, FloodGate& gate,
                         std::vector<std::string>& lines) {
  if (gate.is_cut()) {
    const auto ends = static_cast<std::uint64_t>(std::ranges::count(text, '\n'));
    (void)gate.pass(now, ends + text.size() / kLineMax);
    (void)buffer_.take_rest();
    return;
  }
  std::vector<std::string> more = buffer_.add(text);
  more.resize(gate.pass(now, more.size()));
  lines.insert(lines.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
}

}  // namespace timsctl::robot
