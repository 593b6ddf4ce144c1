// Members of the fleet "f" for tests.
#pragma once

#include <cstdint>
#include <string>

#include "security/keys/identity.h"

namespace tims::security {

inline Identity robot(std::uint16_t system) {
  return {.fleet = "f",
          .role = MemberRole::kSystem,
          .system = system,
          .id = 1,
          .name = "robot" + std::to_string(system),
          .rights = {}};
}

}  // namespace tims::security
