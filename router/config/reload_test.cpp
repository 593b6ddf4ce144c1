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

std::vector<std::string> texts(const Config& before, const Config& after) {
  std::vector<std::string> list;
  for (const Change& change : changes(before, after)) list.push_back(change.to_string());
  return list;
}

TEST(Reload, LinksComeAndGoWithoutARestart) {
  const Config before = with({"security.insecure=true", "link=kind=super,to=10.9.1.1",
                              "link=kind=sub,system=1", "route=match=Ladar(3/*),via=a"});
  const Config after = with({"security.insecure=true", "link=kind=sub,system=1,rate=6MB",
                             "link=kind=peer,to=robot2", "route=match=Ladar(3/*),via=b"});
  ASSERT_EQ(before.links.size() + after.links.size(), 4U);
  EXPECT_THAT(texts(before, after),
              testing::ElementsAre("link \"sub of system 1\" rate: \"0B\" -> \"6MB\"",
                                   "link \"robot2:2010\": added", "link \"10.9.1.1:2010\": removed",
                                   "route \"Ladar(3/*)\" via: \"a\" -> \"b\""));
  EXPECT_EQ(reloaded(before, after), after);
  for (const Change& change : changes(before, after)) EXPECT_TRUE(change.reloadable);
}

TEST(Reload, TheOrderOfLinksIsAChange) {
  const std::string one = "link=kind=super,to=127.0.0.1:1";
  const std::string two = "link=kind=super,to=127.0.0.1:2";
  EXPECT_THAT(texts(with({one, two}), with({two, one})),
              testing::ElementsAre("link: in another order"));
  EXPECT_EQ(reloaded(with({one, two}), with({two, one})), with({two, one}));
}

TEST(Reload, EveryChangeOfALinkIsTold) {
  const Config before = with({"link=kind=super,to=127.0.0.1"});
  for (const char* key :
       {"name=a", "mailboxes=9", "interval=1s", "rate=1MB", "reserve=0", "lifetime=1s"}) {
    const Config after = with({std::string("link=kind=super,to=127.0.0.1,") + key});
    EXPECT_EQ(changes(before, after).size(), 1U) << key;
    EXPECT_EQ(reloaded(before, after), after) << key;
  }
  EXPECT_EQ(changes(before, with({"link=kind=peer,to=127.0.0.1"})).size(), 1U);
}

TEST(Reload, LinksWaitForWhatTheyWereCheckedAgainst) {
  const Config running = with({"router.role=subsystem", "link=kind=super,to=127.0.0.1"});
  const Config wanted = with({"router.role=system", "link=kind=sub", "log.level=debug"});
  const Config now = reloaded(running, wanted);
  EXPECT_EQ(now.links, running.links);
  EXPECT_EQ(now.log.level, LogLevel::kDebug);
  EXPECT_THAT(texts(now, wanted),
              testing::ElementsAre("router.role: \"subsystem\" -> \"system\", needs a restart",
                                   "link \"sub of *\": added, needs a restart",
                                   "link \"127.0.0.1:2010\": removed, needs a restart"));
}

}  // namespace
}  // namespace tims::config
