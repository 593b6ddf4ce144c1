// What programs write, line by line. Pure.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace timsctl::robot {

inline constexpr std::size_t kLineMax = 4096;  // a longer one is cut in pieces

class LineBuffer {
 public:
  // The lines that are complete now, without their ends.
  std::vector<std::string> add(std::string_view text);
  // What is left at the end of all.
  std::string take_rest() { return std::exchange(rest_, {}); }

 private:
  std::string rest_;
};

}  // namespace timsctl::robot
