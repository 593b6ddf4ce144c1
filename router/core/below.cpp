#include "router/core/below.h"

#include "router/core/random.h"

namespace tims::core {

std::uint32_t table_hash(Address address, const Origin& origin) {
  std::uint64_t h =
      (std::uint64_t{address.raw()} << 32 | origin.router.raw()) + 0x9E3779B97F4A7C15U;
  h ^= (std::uint64_t{origin.epoch} << 8 | origin.hops) * 0xC2B2AE3D27D4EB4FU;
  h = spread(h);
  return static_cast<std::uint32_t>(h ^ h >> 32);
}

}  // namespace tims::core
