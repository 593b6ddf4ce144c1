#include "tools/timsctl/robot/line_buffer.h"

namespace timsctl::robot {

std::vector<std::string> LineBuffer::add(std::string_view text) {
  std::vector<std::string> lines;
  for (const char c : text) {
    if (c != '\n') rest_ += c;
    if (c == '\n' || rest_.size() == kLineMax) lines.push_back(take_rest());
  }
  return lines;
}

}  // namespace timsctl::robot
