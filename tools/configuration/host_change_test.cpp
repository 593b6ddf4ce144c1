#include "tools/configuration/host_change.h"

#include <gtest/gtest.h>

namespace timsctl::configuration {
namespace host_change_test {

using namespace std::chrono_literals;
using tims::Time;

constexpr Time kStart = Time(100s);

Item item(const std::string& change, std::vector<std::string> others = {}) {
  return {.change = change, .who = "tablet 2", .why = "test", .others = std::move(others)};
}

// Does all steps; returns the generation whose files were written last.
Generation run(HostChange& host, Time now) {
  Generation written = 0;
  while (const Step* step = host.step()) {
    if (step->kind == Step::Kind::kWrite) written = step->generation;
    host.done(now);
  }
  return written;
}

HostChange new_host() {
  HostChange host(kStart, {});
  EXPECT_EQ(host.found("t", "root"), 1U);
  run(host, kStart);
  return host;
}

TEST(HostChange, IsKeptWhenItIsConfirmedInTime) {
  HostChange host = new_host();
  ASSERT_FALSE(host.begin(kStart, item("a"), 90s));
  EXPECT_TRUE(host.confirm(kStart, "a")) << "before it is applied";
  EXPECT_EQ(run(host, kStart), 2U);
  EXPECT_EQ(host.state(kStart), State::kWaiting);
  EXPECT_EQ(host.left(kStart + 30s), 60s);
  EXPECT_FALSE(host.confirm(kStart + 89s, "a"));
  run(host, kStart);
  EXPECT_EQ(host.state(kStart), State::kIdle);
  EXPECT_EQ(host.record().current, 2U);
  EXPECT_FALSE(host.confirm(kStart, "a")) << "a repeated confirmation is none the worse";
  EXPECT_EQ(host.next_timeout(), tims::kNever);
}

TEST(HostChange, GoesBackAtTheEndOfTheWindow) {
  HostChange host = new_host();
  ASSERT_FALSE(host.begin(kStart, item("a"), 90s));
  run(host, kStart);
  host.on_timeout(kStart + 90s - 1ns);
  EXPECT_EQ(host.state(kStart), State::kWaiting);
  EXPECT_EQ(host.next_timeout(), kStart + 90s);
  host.on_timeout(kStart + 90s);
  EXPECT_EQ(run(host, kStart + 90s), 1U);
  EXPECT_EQ(host.record().current, 1U);
  EXPECT_EQ(host.record().find(2)->outcome, Outcome::kWentBack);
  EXPECT_EQ(host.record().find(2)->reason, "not confirmed in 90 s");
  EXPECT_TRUE(host.confirm(kStart + 91s, "a"));
}

TEST(HostChange, WindowIsBounded) {
  for (const auto& [wanted, window] :
       {std::pair<tims::Duration, tims::Duration>{2s, 3s}, {3s, 3s}, {600s, 600s}, {601s, 600s}}) {
    HostChange host = new_host();
    ASSERT_FALSE(host.begin(kStart, item("a"), wanted));
    run(host, kStart);
    EXPECT_EQ(host.left(kStart), window);
  }
}

TEST(HostChange, OneChangeAtATime) {
  HostChange host = new_host();
  EXPECT_FALSE(host.lock(kStart, "a", "tablet 2", 60s));
  EXPECT_EQ(host.lock(kStart, "b", "tablet 3", 60s)->code, "locked");
  EXPECT_EQ(host.begin(kStart, item("b"), 90s)->code, "locked");
  EXPECT_FALSE(host.begin(kStart + 60s, item("b"), 90s)) << "the lock has ended";
  EXPECT_EQ(host.begin(kStart, item("a"), 90s)->code, "busy");
  EXPECT_EQ(host.lock(kStart, "a", "tablet 2", 60s)->code, "busy");
  run(host, kStart);
  EXPECT_FALSE(host.confirm(kStart, "b"));
  run(host, kStart);
  EXPECT_EQ(host.begin(kStart, item("b"), 90s)->code, "bad_argument") << "an id is used once";
}

// After a crash between any two steps of a change, the files are those of before.
TEST(HostChange, GoesBackAfterACrashAtAnyStep) {
  for (int crash = 0; crash < 8; ++crash) {
    HostChange host = new_host();
    Record disk = host.record();
    Generation files = 1;
    Time now = kStart;
    const auto step = [&](HostChange& any) {
      if (any.step()->kind == Step::Kind::kSave) disk = any.record();
      if (any.step()->kind == Step::Kind::kWrite) files = any.step()->generation;
      any.done(now);
    };
    ASSERT_FALSE(host.begin(now, item("a"), 90s));
    for (int i = 0; i < crash; ++i) {
      if (host.step() == nullptr) host.on_timeout(now += 100s);
      step(host);
    }
    HostChange again(now, disk);
    while (again.step() != nullptr) step(again);
    EXPECT_EQ(files, 1U) << crash;
    EXPECT_EQ(again.record().current, 1U) << crash;
    EXPECT_EQ(again.state(now), State::kIdle) << crash;
    EXPECT_EQ(disk, again.record()) << crash;
    if (disk.find(2) != nullptr) {
      EXPECT_EQ(disk.find(2)->outcome, Outcome::kWentBack);
    }
  }
}

TEST(HostChange, AFailedStepGoesBackAndAFailedWayBackIsTriedAgain) {
  HostChange host = new_host();
  ASSERT_FALSE(host.begin(kStart, item("a"), 90s));
  host.done(kStart);
  host.failed(kStart, "disk full");
  EXPECT_EQ(host.state(kStart), State::kGoingBack);
  host.failed(kStart, "disk full");
  EXPECT_EQ(host.step(), nullptr);
  host.on_timeout(kStart + kAskPeers);
  EXPECT_EQ(run(host, kStart + kAskPeers), 1U);
  EXPECT_EQ(host.record().find(2)->reason, "disk full");
}

TEST(HostChange, SettlesWhenTheOthersAreConfirmed) {
  HostChange host = new_host();
  ASSERT_FALSE(host.begin(kStart, item("a", {"B", "C"}), 90s));
  run(host, kStart);
  ASSERT_FALSE(host.confirm(kStart, "a"));
  run(host, kStart);
  EXPECT_EQ(host.state(kStart), State::kSettling);
  EXPECT_EQ(host.peers_to_ask(kStart).size(), 2U);
  host.answered(kStart, "B", "a", Standing::kConfirmed);
  host.answered(kStart, "C", "a", Standing::kUnderWay);
  EXPECT_EQ(host.peers_to_ask(kStart + kAskPeers).size(), 1U);
  host.heard(kStart, "D", "a", Standing::kWentBack);
  EXPECT_EQ(host.state(kStart), State::kSettling) << "D is no host of this change";
  host.answered(kStart, "C", "a", Standing::kConfirmed);
  run(host, kStart);
  EXPECT_EQ(host.state(kStart), State::kIdle);
  EXPECT_EQ(host.record().current, 2U);
}

TEST(HostChange, GoesBackWhenAnotherHostDidAlsoAfterwards) {
  HostChange host = new_host();
  ASSERT_FALSE(host.begin(kStart, item("a", {"B"}), 90s));
  run(host, kStart);
  ASSERT_FALSE(host.confirm(kStart, "a"));
  host.answered(kStart, "B", "a", Standing::kConfirmed);
  run(host, kStart);
  ASSERT_EQ(host.record().current, 2U);
  host.heard(kStart + 1h, "B", "a", Standing::kWentBack);
  EXPECT_EQ(run(host, kStart + 1h), 1U);
  EXPECT_EQ(host.record().current, 1U);
  // It tells B, until B has answered.
  const auto peers = host.peers_to_ask(kStart + 1h);
  ASSERT_EQ(peers.size(), 1U);
  EXPECT_EQ(peers[0].own, Standing::kWentBack);
  host.answered(kStart + 1h, "B", "a", Standing::kWentBack);
  EXPECT_TRUE(host.peers_to_ask(kStart + 2h).empty());
}

TEST(HostChange, ANewerChangeIsNotTouchedByAnOldOne) {
  HostChange host = new_host();
  ASSERT_FALSE(host.begin(kStart, item("a", {"B"}), 90s));
  run(host, kStart);
  ASSERT_FALSE(host.confirm(kStart, "a"));
  host.answered(kStart, "B", "a", Standing::kConfirmed);
  run(host, kStart);
  ASSERT_FALSE(host.begin(kStart, item("b"), 90s));
  run(host, kStart);
  ASSERT_FALSE(host.confirm(kStart, "b"));
  run(host, kStart);
  host.heard(kStart, "B", "a", Standing::kWentBack);
  EXPECT_EQ(host.step(), nullptr);
  EXPECT_EQ(host.record().current, 3U);
}

TEST(HostChange, KeepsTwentyGenerations) {
  HostChange host = new_host();
  for (int i = 0; i < 30; ++i) {
    const std::string change = "c" + std::to_string(i);
    ASSERT_FALSE(host.begin(kStart, item(change), 90s));
    run(host, kStart);
    ASSERT_FALSE(host.confirm(kStart, change));
    run(host, kStart);
  }
  EXPECT_EQ(host.record().items.size(), kGenerationsKept);
  EXPECT_EQ(host.record().items.back().generation, 31U);
  EXPECT_EQ(host.record().current, 31U);
}

}  // namespace host_change_test
}  // namespace timsctl::configuration
