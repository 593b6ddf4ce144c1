#include "components/runtime/logic/readable_name.h"

#include <algorithm>

namespace rack {
namespace {

class Writer {
 public:
  explicit Writer(std::span<char> room) : room_(room) {}
  void put(std::string_view text) {
    const std::size_t size = std::min(text.size(), room_.size() - size_);
    std::copy_n(text.data(), size, room_.data() + size_);
    size_ += size;
  }
  [[nodiscard]] std::string_view text() const { return {room_.data(), size_}; }

 private:
  std::span<char> room_;
  std::size_t size_ = 0;
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// "4rack" and what follows; an empty name when it is none.
std::string_view take_name(std::string_view& rest) {
  std::size_t size = 0;
  std::size_t at = 0;
  for (; at < rest.size() && is_digit(rest[at]) && size < rest.size(); ++at)
    size = size * 10 + static_cast<std::size_t>(rest[at] - '0');
  if (at == 0 || size > rest.size() - at) return {};
  const std::string_view name = rest.substr(at, size);
  rest.remove_prefix(at + size);
  return name;
}

// C1: a constructor; D0: a destructor. They have their class's name.
bool is_special(std::string_view rest, char letter) {
  return rest.size() > 1 && rest[0] == letter && is_digit(rest[1]);
}

// The parts of a name, up to E.
bool write_nested(std::string_view rest, Writer& to) {
  std::string_view last;
  bool first = true;
  while (!rest.empty() && rest.front() != 'E') {
    if (!first) to.put("::");
    if (is_special(rest, 'C') || is_special(rest, 'D')) {
      if (rest[0] == 'D') to.put("~");
      to.put(last);
      rest.remove_prefix(2);
      continue;
    }
    last = take_name(rest);
    if (last.empty()) return false;
    to.put(last.starts_with("_GLOBAL__N") ? "(anonymous namespace)" : last);
    first = false;
  }
  return !rest.empty() && !first;
}

bool write(std::string_view mangled, Writer& to) {
  if (!mangled.starts_with("_Z")) return false;
  mangled.remove_prefix(2);
  if (!mangled.starts_with('N')) {
    const std::string_view name = take_name(mangled);
    to.put(name);
    return !name.empty();
  }
  mangled.remove_prefix(1);
  while (!mangled.empty() && (mangled[0] == 'K' || mangled[0] == 'V')) mangled.remove_prefix(1);
  return write_nested(mangled, to);
}

}  // namespace

std::string_view readable_name(std::string_view mangled, std::span<char> room) {
  Writer to(room);
  if (write(mangled, to)) return to.text();
  Writer as_it_is(room);
  as_it_is.put(mangled);
  return as_it_is.text();
}

}  // namespace rack
