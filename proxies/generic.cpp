#include "proxies/generic.h"

namespace rack {

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
