#include "router/config/options.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/load.h"

namespace tims::config {
namespace {

const Host kRoot{.name = "robot1", .uid = 0, .environment = {}};

TEST(Options, KeysAreUniqueAndTablesStandTogether) {
  std::set<std::string_view> keys;
  std::set<std::string_view> closed;
  std::string_view table;
  for (const Option& option : options()) {
    EXPECT_TRUE(keys.insert(option.key).second) << option.key;
    const bool opened = option.table() != table;
    EXPECT_TRUE(!opened || closed.insert(option.table()).second) << option.key;
    table = option.table();
  }
}

TEST(Options, EveryDefaultIsInItsRange) {
  const Config config = defaults(kRoot);
  for (const Option& option : options())
    EXPECT_TRUE(check_range(option.kind, option.range, option.get(config)).ok()) << option.key;
}

TEST(Options, SetGivesBackWhatGetGave) {
  if (!kHasDds) GTEST_SKIP() << "one of them needs DDS";
  const Loaded other = load({{},
                             {"router.name=x",
                              "router.system=9",
                              "router.id=8",
                              "unix.path=/x",
                              "unix.everybody=true",
                              "tcp.listen=off",
                              "tcp.compat_delete=true",
                              "tcp.admin=true",
                              "http.origins=http://robot7:3000",
                              "tcp.queue=1MiB",
                              "http.listen=[::1]:1",
                              "fleet.name=harbour",
                              "dds.domain=7",
                              "dds.multicast=false",
                              "dds.peers=10.9.1.1",
                              "dds.server=10.9.1.1:11811",
                              "dds.lease=1s",
                              "dds.message=1KiB",
                              "dds.history=5",
                              "dds.heartbeat=1ms",
                              "dds.profiles=/x.xml",
                              "message.max=1MiB",
                              "message.classes=1/2/3/4/5/6/7",
                              "lifesign.interval=1s",
                              "limits.clients=5",
                              "limits.mailboxes_per_client=6",
                              "log.level=error",
                              "security.insecure=true",
                              "router.role=subsystem",
                              "router.priority=5",
                              "address.widths=6/8/10/8",
                              "sim.faults=true"},
                             kRoot});
  ASSERT_TRUE(other.ok());
  Config copy = defaults(kRoot);
  for (const Option& option : options()) {
    EXPECT_NE(option.get(copy), option.get(other.config)) << option.key << " is not set above";
    option.set(copy, option.get(other.config));
  }
  EXPECT_EQ(copy, other.config);
}

TEST(Options, EntriesAreEverythingThatHasAValue) {
  const Loaded loaded =
      load({{}, {"link=kind=super,to=127.0.0.1", "link=kind=sub", "route=match=*,via=x"}, kRoot});
  std::vector<std::string> keys;
  for (const Entry& entry : entries(loaded.config)) keys.push_back(entry.key);
  EXPECT_EQ(keys.front(), "router.name");
  keys.erase(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(options().size()));
  EXPECT_THAT(keys, testing::ElementsAre(
                        "link[0].kind", "link[0].to", "link[0].paths", "link[0].name",
                        "link[0].mailboxes", "link[0].interval", "link[0].rate", "link[0].reserve",
                        "link[0].lifetime", "link[1].kind", "link[1].system", "link[1].paths",
                        "link[1].name", "link[1].mailboxes", "link[1].interval", "link[1].rate",
                        "link[1].reserve", "link[1].lifetime", "route[0].match", "route[0].via"));
}

TEST(Options, AreFoundByKey) {
  ASSERT_NE(find_option("tcp.queue"), nullptr);
  EXPECT_EQ(find_option("tcp.queue")->table(), "tcp");
  EXPECT_EQ(find_option("tcp.queue")->name(), "queue");
  EXPECT_EQ(find_option("tcp"), nullptr);
}

}  // namespace
}  // namespace tims::config
