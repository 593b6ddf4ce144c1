#include "tools/cli/random_id.h"

#include <random>

#include <fmt/format.h>

namespace timsctl {

std::string random_id() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

}  // namespace timsctl
