#include "router/core/priority_classes.h"

namespace tims::core {

std::string PriorityClasses::to_string() const {
  std::string text;
  for (const std::uint8_t first : from)
    text.append(text.empty() ? "" : "/").append(std::to_string(first));
  return text;
}

}  // namespace tims::core
