#include "components/runtime/log_text.h"

#include <algorithm>
#include <array>
#include <exception>

namespace rack {
namespace {

// A character of UTF-8 that begins within the body is complete, so that encode() can cut before it.
constexpr std::size_t kRoom = gdos::kBodyMax + 3;

}  // namespace

std::size_t log_text(gdos::Body& body, fmt::string_view format, fmt::format_args arguments) {
  std::array<char, kRoom> room{};
  try {
    const auto done = fmt::vformat_to_n(room.data(), room.size(), format, arguments);
    return gdos::encode(body, {room.data(), std::min(done.size, room.size())});
  } catch (const std::exception&) {
    return gdos::encode(body, {format.data(), format.size()});
  }
}

}  // namespace rack
