#include "rack/proxies/generic.h"

#include <array>

namespace rack {

std::string_view reason_of(std::span<const std::byte> body) {
  const std::string_view text(reinterpret_cast<const char*>(body.data()), body.size());
  return text.substr(0, text.find('\0'));
}

std::string_view name(Status status) {
  switch (status) {
    case Status::kEnabled:
      return "enabled";
    case Status::kDisabled:
      return "disabled";
    case Status::kError:
      return "error";
  }
  return "unknown";
}

std::string_view name(TakesEffect when) {
  constexpr std::array<std::string_view, 3> kNames = {"now", "at the next ON",
                                                      "when its program starts again"};
  const auto i = static_cast<std::size_t>(when);
  return i < kNames.size() ? kNames[i] : "unknown";
}

std::string_view name(WatchDepth depth) {
  constexpr std::array<std::string_view, 4> kNames = {"off", "counts", "places of page faults",
                                                      "places"};
  const auto i = static_cast<std::size_t>(depth);
  return i < kNames.size() ? kNames[i] : "unknown";
}

}  // namespace rack
