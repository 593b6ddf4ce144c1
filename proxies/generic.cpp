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

}  // namespace rack
