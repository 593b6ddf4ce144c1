#include <gtest/gtest.h>

#include "router/config/load.h"
#include "router/config/options.h"

namespace tims::config {
namespace {

const Host kRoot{.name = "robot1", .uid = 0, .environment = {}};

TEST(OptionsOfItems, GiveBackWhatWasSet) {
  if (!kHasDds) GTEST_SKIP() << "one of them needs DDS";
  const std::string link =
      "link=kind=peer,to=robot2:1,paths=dds+udp,name=x,mailboxes=9,interval=1s,rate=1MB,reserve=5,"
      "lifetime=1s";
  const Loaded other = load({{},
                             {"security.insecure=true", "fleet.name=harbour", link,
                              "link=kind=sub,system=1", "route=match=*,via=x"},
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

}  // namespace
}  // namespace tims::config
