#include "rack/proxies/generic.h"

namespace rack {

std::string_view reason_of(std::span<const std::byte> body) {
  const std::string_view words(reinterpret_cast<const char*>(body.data()), body.size());
  return words.substr(0, words.find('\0'));
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
  switch (when) {
    case TakesEffect::kNow:
      return "now";
    case TakesEffect::kAtOn:
      return "at the next ON";
    case TakesEffect::kAtStart:
      return "when its program starts again";
  }
  return "unknown";
}

std::string_view name(WatchDepth depth) {
  switch (depth) {
    case WatchDepth::kOff:
      return "off";
    case WatchDepth::kCounts:
      return "counts";
    case WatchDepth::kFaultPlaces:
      return "places of page faults";
    case WatchDepth::kAllPlaces:
      return "places";
  }
  return "unknown";
}

}  // namespace rack
