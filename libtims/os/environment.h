// Variables of the environment. Nobody here changes one.
#pragma once

#include <cstdlib>
#include <string>

namespace tims::os {

// Empty: not set, or set to nothing.
inline std::string environment(const char* name) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return text == nullptr ? "" : text;
}

}  // namespace tims::os
