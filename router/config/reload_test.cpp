#include "router/config/reload.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/load.h"

namespace tims::config {
namespace {

const Host kHost{.name = "robot1", .uid = 0, .environment = {}};

Config with(std::vector<std::string> settings) {
  return load({{}, std::move(settings), kHost}).config;
}

TEST(Reload, NothingChangedIsAnEmptyList) {
  EXPECT_TRUE(changes(defaults(kHost), defaults(kHost)).empty());
}

TEST(Reload, ChangesAreNamedInTheOrderOfTheTable) {
  std::vector<std::string> texts;
  for (const Change& change :
       changes(defaults(kHost), with({"log.level=debug", "router.id=2", "tcp.listen=off"})))
    texts.push_back(change.to_string());
  EXPECT_THAT(texts,
              testing::ElementsAre("router.id: 1 -> 2, needs a restart",
                                   "tcp.listen: \"127.0.0.1:2000\" -> \"off\", needs a restart",
                                   "log.level: \"info\" -> \"debug\""));
}

TEST(Reload, OnlyReloadableValuesAreTaken) {
  const Config running = defaults(kHost);
  const Config wanted = with({"log.level=debug", "router.id=2", "tcp.queue=1MiB"});
  const Config now = reloaded(running, wanted);
  EXPECT_EQ(now.log.level, LogLevel::kDebug);
  EXPECT_EQ(now.tcp.queue_bytes, 1U << 20);
  EXPECT_EQ(now.router.id, 1);
  for (const Change& change : changes(now, wanted)) EXPECT_FALSE(change.reloadable) << change.key;
}

}  // namespace
}  // namespace tims::config
