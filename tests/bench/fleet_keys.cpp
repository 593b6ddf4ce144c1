#include "tests/bench/fleet_keys.h"

#include <chrono>
#include <filesystem>

namespace tims::bench {
namespace {

constexpr const char* kFleetName = "bench";

std::int64_t wall_seconds() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

Result<FleetKeys> FleetKeys::make(std::string folder) {
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  std::filesystem::create_directories(folder, ignored);
  auto authority = security::Authority::init(security::KeyFolder(folder + "/authority"), kFleetName,
                                             wall_seconds());
  if (!authority) return authority.error();
  return FleetKeys(std::move(folder), std::move(*authority));
}

Result<void> FleetKeys::add(security::MemberRole role, std::uint16_t system,
                            std::uint16_t id) const {
  const security::Identity identity{.fleet = kFleetName,
                                    .role = role,
                                    .system = system,
                                    .id = id,
                                    .name = security::usual_name(role, system, id),
                                    .rights = {}};
  return authority_.issue_to(security::KeyFolder(folder_of(role, system, id)), identity, {},
                             wall_seconds());
}

std::string FleetKeys::folder_of(security::MemberRole role, std::uint16_t system,
                                 std::uint16_t id) const {
  return folder_of(folder_, role, system, id);
}

std::string FleetKeys::folder_of(const std::string& folder, security::MemberRole role,
                                 std::uint16_t system, std::uint16_t id) {
  return folder + "/" + std::string(name(role)) + std::to_string(system) + "-" + std::to_string(id);
}

}  // namespace tims::bench
