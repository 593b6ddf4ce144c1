#include "router/link/bundle.h"

#include <algorithm>

namespace tims::link {
namespace {

constexpr std::size_t kPaddingMax = 3;

}  // namespace

bool Bundle::valid() const {
  std::span<const std::byte> rest = bytes_;
  while (rest.size() >= kBundleSizeBytes && size_at(rest, 0) != 0) {
    const std::size_t whole = kBundleSizeBytes + size_at(rest, 0);
    if (whole > rest.size()) return false;
    rest = rest.subspan(whole);
  }
  const auto is_zero = [](std::byte byte) { return byte == std::byte{}; };
  return rest.size() < bytes_.size() && rest.size() <= kPaddingMax &&
         std::ranges::all_of(rest, is_zero);
}

}  // namespace tims::link
