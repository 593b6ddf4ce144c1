#include "tools/sim/fleet_keys.h"

#include <gtest/gtest.h>

#include "security/keys/key_folder.h"
#include "tests/support/temporary_folder.h"
#include "tools/cli/failure.h"
#include "tools/sim/fleet_file.h"

namespace timsctl::sim {
namespace fleet_keys_test {

namespace security = tims::security;

Plan plan_in(const std::string& folder) {
  const FleetFile file = read_fleet({"f", R"toml(
name = "demo"
[[robot]]
system = 7
hosts = ["main", "arm"]
)toml"});
  Plan plan = make_plan(file.fleet);
  for (PlannedHost& host : plan.hosts) host.folder = folder + "/" + host.name;
  return plan;
}

class FleetKeys : public testing::Test {
 protected:
  void make_folders() {
    for (const PlannedHost& host : plan_.hosts) std::filesystem::create_directories(host.folder);
  }

  tims::test::TemporaryFolder folder_;
  const Plan plan_ = plan_in(folder_.path());
};

TEST_F(FleetKeys, EachHostIsWhatItsRouterIs) {
  make_folders();
  make_keys(plan_);
  ASSERT_EQ(plan_.hosts.size(), 3U);
  for (const PlannedHost& host : plan_.hosts) {
    const auto keys = security::KeyFolder(host.keys()).load();
    ASSERT_TRUE(keys.ok()) << keys.error().message();
    EXPECT_EQ(keys->identity.fleet, "demo");
    EXPECT_EQ(keys->identity.name, host.name);
    EXPECT_EQ(name(keys->identity.role), host.role);
    EXPECT_EQ(keys->identity.system, host.system);
    EXPECT_EQ(keys->identity.id, host.id);
    EXPECT_EQ(keys->list_number(), 1U);
  }
}

TEST_F(FleetKeys, AFolderThatCannotBeMadeIsNamed) {
  try {
    make_keys(plan_);
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_NE(failure.message.find(plan_.hosts.front().keys()), std::string::npos)
        << failure.message;
  }
}

}  // namespace fleet_keys_test
}  // namespace timsctl::sim
