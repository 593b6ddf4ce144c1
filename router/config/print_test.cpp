#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/load.h"

namespace tims::config {
namespace {

const Host kHost{.name = "robot1", .uid = 0, .environment = {}};

TEST(PrintConfig, NamesTheOriginOfEveryValue) {
  const Loaded loaded =
      load({{{"r.toml", "[tcp]\n\nqueue = 1048576\n"}}, {"log.level=debug"}, kHost});
  const std::string text = print_config(loaded.config, loaded.origins);
  EXPECT_THAT(text,
              testing::StartsWith("[router]\nname = \"robot1\"                     # default\n"));
  EXPECT_THAT(text, testing::HasSubstr("queue = \"1MiB\"                      # r.toml:3\n"));
  EXPECT_THAT(text, testing::HasSubstr("[log]\nlevel = \"debug\"                     # --set 1\n"));
}

TEST(PrintConfig, LoadsBackToTheSameConfig) {
  const Loaded loaded =
      load({{},
            {"router.name=a \"b\" \\c ${HOSTNAME} $$ #d", "tcp.listen=off", "message.max=262144B",
             "lifesign.interval=1500ms", "http.listen=[::1]:0"},
            kHost});
  ASSERT_TRUE(loaded.ok());
  const std::string text = print_config(loaded.config, loaded.origins);
  const Loaded again = load({{{"printed.toml", text}}, {}, kHost});
  EXPECT_TRUE(again.ok()) << text;
  EXPECT_EQ(again.config, loaded.config) << text;
}

}  // namespace
}  // namespace tims::config
