#include "router/config/options.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/load.h"

namespace tims::config {
namespace options_test {

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
                              "http.names=robot7.local",
                              "http.origins=http://robot7:3000",
                              "http.console=/x",
                              "http.queue=2MiB",
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
                              "dds.beyond_host=true",
                              "message.max=1MiB",
                              "message.classes=1/2/3/4/5/6/7",
                              "message.lifetimes=off 2s, chassis.move 200ms",
                              "lifesign.interval=1s",
                              "limits.clients=5",
                              "limits.mailboxes_per_client=6",
                              "newest.bytes=1MiB",
                              "newest.message=1KiB",
                              "newest.streams=status",
                              "log.level=error",
                              "tcp.plain=loopback, 10.9.0.0/16",
                              "http.certificate=/etc/tims/web.pem",
                              "http.key=/etc/tims/web.key",
                              "security.insecure=true",
                              "security.keys=/etc/tims/keys",
                              "security.refuse_expired=true",
                              "security.list_age_max=72h",
                              "security.refuse_old_list=true",
                              "security.renew_within=1h",
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
  EXPECT_THAT(keys, testing::ElementsAre("link[0].kind", "link[0].to", "link[0].paths",
                                         "link[0].name", "link[0].mailboxes", "link[0].interval",
                                         "link[0].rate", "link[0].reserve", "link[0].lifetime",
                                         "link[0].compress", "link[0].compress_own", "link[1].kind",
                                         "link[1].system", "link[1].paths", "link[1].name",
                                         "link[1].mailboxes", "link[1].interval", "link[1].rate",
                                         "link[1].reserve", "link[1].lifetime", "link[1].compress",
                                         "link[1].compress_own", "route[0].match", "route[0].via"));
}

TEST(Options, AreFoundByKey) {
  ASSERT_NE(find_option("tcp.queue"), nullptr);
  EXPECT_EQ(find_option("tcp.queue")->table(), "tcp");
  EXPECT_EQ(find_option("tcp.queue")->name(), "queue");
  EXPECT_EQ(find_option("tcp"), nullptr);
}

TEST(OptionsOfItems, GiveBackWhatWasSet) {
  if (!kHasDds) GTEST_SKIP() << "one of them needs DDS";
  const std::string link =
      "link=kind=peer,to=robot2:1,paths=dds+udp,name=x,mailboxes=9,interval=1s,rate=1MB,reserve=5,"
      "lifetime=1s,compress=lz4,compress_own=true,secure=false";
  const Loaded other = load({{},
                             {"security.insecure=true", "fleet.name=harbour", link,
                              "link=kind=sub,system=1", "route=match=*,via=x",
                              "rule=name=x,from=own,to=Chassis(3/0),types=look,priority_max=5,"
                              "rate=1MB,then=thin,per_second=3,every=2,bytes_max=1KiB",
                              "test=name=x,from=own,to=Chassis(3/0),type=get_status,priority=1,"
                              "expect=deny"},
                             kRoot});
  ASSERT_TRUE(other.ok());
  for (const List& list : lists()) {
    Config copy = defaults(kRoot);
    list.append(copy);
    for (const Option& option : list.options) {
      EXPECT_TRUE(option.key.starts_with(list.name)) << option.key;
      EXPECT_EQ(list.find(option.name()), &option);
      const std::size_t item = option.key == "link.system" ? 1 : 0;
      EXPECT_NE(option.get(copy), option.get(other.config, item)) << option.key;
      option.set(copy, option.get(other.config, item));
      EXPECT_EQ(option.get(copy), option.get(other.config, item)) << option.key;
    }
  }
}

TEST(OptionsOfItems, HaveDefaultsInTheirRanges) {
  Config config;
  for (const List& list : lists()) {
    list.append(config);
    for (const Option& option : list.options)
      if (option.default_note.empty()) {
        EXPECT_TRUE(check_range(option.kind, option.range, option.get(config)).ok()) << option.key;
      }
  }
}

TEST(OptionsOfItems, AreFoundByName) {
  ASSERT_NE(find_list("link"), nullptr);
  EXPECT_EQ(find_list("link")->find("to")->key, "link.to");
  EXPECT_EQ(find_list("link")->find("match"), nullptr);
  EXPECT_EQ(find_list("links"), nullptr);
}

// As the shell hands it over.
std::string unquoted(std::string_view setting) {
  std::string text(setting);
  std::erase(text, '\'');
  return text;
}

TEST(Options, HelpNamesEveryKeyWithLimitsAndDefault) {
  const std::string help = options_help();
  for (const Option& option : options())
    EXPECT_THAT(help, testing::HasSubstr("  " + std::string(option.key) + "  ("));
  for (const List& list : lists())
    for (const Option& option : list.options)
      EXPECT_THAT(help, testing::HasSubstr("  " + std::string(option.key) + "  ("));
  EXPECT_THAT(help, testing::HasSubstr("tcp.queue  (size, 64KiB to 1GiB; default \"4MiB\")"));
  EXPECT_THAT(help, testing::HasSubstr("unix.path  (text, 1 to 107 bytes long; default /run/"));
}

TEST(Options, HelpLinesFitOnAScreen) {
  std::istringstream lines(options_help() + sample_file());
  for (std::string line; std::getline(lines, line);)
    EXPECT_TRUE(line.size() <= 100U || line.ends_with(')')) << line;
}

// The sample without its switches: up to the first example of a list, and from there.
std::pair<std::string, std::string> uncommented() {
  std::istringstream lines(sample_file());
  std::string options;
  std::string items;
  for (std::string line; std::getline(lines, line);) {
    const bool switched_off = line.starts_with('#') && !line.starts_with("# ");
    const bool is_item = !items.empty() || line.starts_with("#[[");
    (is_item ? items : options) += line.substr(switched_off ? 1 : 0) + '\n';
  }
  return {options, items};
}

TEST(SampleFile, UncommentedItGivesTheDefaults) {
  const Loaded loaded = load({{{"router.toml", uncommented().first}}, {}, kRoot});
  EXPECT_TRUE(loaded.ok()) << (loaded.ok() ? "" : loaded.problems.front().to_string());
  EXPECT_EQ(loaded.config, defaults(kRoot));
  EXPECT_EQ(loaded.origins.size(), options().size());
}

TEST(SampleFile, ItsExamplesAreRight) {
  if (!kHasDds) GTEST_SKIP() << "one of them needs DDS";
  const Loaded loaded = load({{{"items.toml", uncommented().second}},
                              {"security.insecure=true", "fleet.name=harbour"},
                              kRoot});
  EXPECT_TRUE(loaded.ok()) << (loaded.ok() ? "" : loaded.problems.front().to_string());
  for (const List& list : lists()) {
    EXPECT_GT(list.size(loaded.config), 0U) << list.name;
    EXPECT_TRUE(load({{}, {"security.insecure=true", unquoted(list.sample_setting)}, kRoot}).ok());
  }
}

TEST(SampleFile, TheExampleOfRulesIsRight) {
  std::ifstream stream(std::filesystem::path(TIMS_SAMPLE_FILE).parent_path() /
                       "policies/robot.toml");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const Loaded loaded = load({{{"robot.toml", text}}, {}, kRoot});
  EXPECT_TRUE(loaded.ok()) << loaded.problems.front().to_string();
  EXPECT_GE(loaded.config.rules.size(), 5U);
  EXPECT_GE(loaded.config.tests.size(), 4U);
}

TEST(SampleFile, InDeployIsTheGeneratedOne) {
  std::ifstream stream(TIMS_SAMPLE_FILE);
  const std::string deployed{std::istreambuf_iterator<char>(stream), {}};
  if (deployed == sample_file()) return;
  const std::string generated = testing::TempDir() + "tims-router.toml";
  std::ofstream(generated) << sample_file();
  FAIL() << "the option table has changed: cp " << generated << " " << TIMS_SAMPLE_FILE;
}

}  // namespace options_test

}  // namespace tims::config
