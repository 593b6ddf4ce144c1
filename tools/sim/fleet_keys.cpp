#include "tools/sim/fleet_keys.h"

#include <chrono>

#include "os/clock.h"
#include "security/keys/authority.h"
#include "tools/cli/failure.h"

namespace timsctl::sim {
namespace {

namespace security = tims::security;

security::Identity identity_of(const Plan& plan, const PlannedHost& host) {
  return {.fleet = plan.name,
          .role = *security::role_of(host.role),
          .system = host.system,
          .id = host.id,
          .name = host.name,
          .rights = {}};
}

}  // namespace

void make_keys(const Plan& plan) {
  const std::int64_t now =
      std::chrono::duration_cast<std::chrono::seconds>(tims::os::wall_now().time_since_epoch())
          .count();
  const PlannedHost& base = plan.hosts.front();
  const auto authority = value_or_fail(
      security::Authority::init(security::KeyFolder(base.keys()), plan.name, now), base.keys());
  value_or_fail(authority.issue_own(identity_of(plan, base), {base.name}, now), base.keys());
  for (const PlannedHost& host : plan.hosts) {
    if (&host == &base) continue;
    value_or_fail(authority.issue_to(security::KeyFolder(host.keys()), identity_of(plan, host),
                                     {host.name}, now),
                  host.keys());
  }
}

}  // namespace timsctl::sim
