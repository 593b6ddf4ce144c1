#include "router/link/paths.h"

#include <algorithm>
#include <tuple>

#include <gtest/gtest.h>

namespace tims::link {
namespace paths_test {

using namespace std::chrono_literals;

// Probes until there is nothing to try, on a path that carries so much.
Time probe_all(PathMtu& mtu, Time now, std::size_t carries, std::size_t most = kDatagramMax) {
  while (mtu.next_probe(most) < now + 1min) {
    now = std::max(now, mtu.next_probe(most));
    const std::size_t size = mtu.probe(now, most);
    mtu.on_probe_sent(size);
    size <= carries ? mtu.on_probe_acked(now, size) : mtu.on_probe_lost(now);
  }
  return now;
}

TEST(PathMtu, FindsTheLargestThatPasses) {
  for (const auto& [carries, found] :
       {std::pair{1200, 1200}, {1371, 1200}, {1372, 1372}, {1472, 1472}, {60'000, 8972}}) {
    PathMtu mtu;
    probe_all(mtu, Time{1s}, static_cast<std::size_t>(carries));
    EXPECT_EQ(mtu.size(), static_cast<std::size_t>(found));
  }
}

TEST(PathMtu, TriesNothingAboveWhatIsWanted) {
  PathMtu mtu;
  probe_all(mtu, Time{1s}, 60'000, kDatagramEthernet);
  EXPECT_EQ(mtu.size(), kDatagramEthernet);
  EXPECT_EQ(mtu.next_probe(kDatagramEthernet), kNever);
  EXPECT_NE(mtu.next_probe(kDatagramMax), kNever);
}

TEST(PathMtu, SixLargeOnesInARowAreABlackHole) {
  PathMtu mtu;
  const Time now = probe_all(mtu, Time{1s}, 1472);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(mtu.on_lost(now, 1472, now));
  mtu.on_acked(1472, now);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(mtu.on_lost(now, 1472, now));
  EXPECT_FALSE(mtu.on_lost(now, 1200, now));
  EXPECT_TRUE(mtu.on_lost(now, 1472, now));
  EXPECT_EQ(mtu.size(), kDatagramBase);
}

// For example 1124 bytes with IP and UDP: a VPN in a tunnel.
TEST(PathMtu, APathOfLessThan1200BytesIsFoundDownTo548) {
  for (const auto& [carries, found] :
       {std::pair{1199, 1136}, {1096, 1064}, {972, 968}, {799, 548}, {548, 548}}) {
    PathMtu mtu;
    Time now = probe_all(mtu, Time{1s}, static_cast<std::size_t>(carries));
    EXPECT_EQ(mtu.size(), kDatagramBase) << "it was not lost yet";
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(mtu.on_lost(now, 1200, now));
    EXPECT_TRUE(mtu.on_lost(now, 1200, now));
    EXPECT_EQ(mtu.size(), kDatagramMin);
    EXPECT_FALSE(mtu.on_lost(now, 1200, now)) << "sent before";
    now = probe_all(mtu, now, static_cast<std::size_t>(carries));
    EXPECT_EQ(mtu.size(), static_cast<std::size_t>(found));
    EXPECT_LE(mtu.next_probe(kDatagramEthernet), now + 5min);
    now = probe_all(mtu, mtu.next_probe(kDatagramEthernet), 1472);
    EXPECT_EQ(mtu.size(), 1472U) << "the tunnel is gone";
  }
}

// What was sent during an outage is lost at whatever size.
TEST(PathMtu, LossesBeforeALargeOneThatArrivedAreNotABlackHole) {
  PathMtu mtu;
  const Time now = probe_all(mtu, Time{1s}, 1472);
  mtu.on_acked(1472, now + 1ms);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(mtu.on_lost(now + 2ms, 1472, now));
  EXPECT_EQ(mtu.size(), 1472U);
  for (int i = 0; i < 6; ++i) (void)mtu.on_lost(now + 2ms, 1472, now + 2ms);
  EXPECT_EQ(mtu.size(), kDatagramBase);
}

using namespace std::chrono_literals;

constexpr Duration kKeepAlive = 300ms;
constexpr Duration kRtt = 10ms;
const NetAddress kUdp = NetAddress::v4(10, 0, 0, 1, 2010);
const NetAddress kMoved = NetAddress::v4(10, 0, 0, 2, 2010);
const NetAddress kElsewhere = NetAddress::v4(10, 0, 0, 3, 2010);
const NetAddress kDds = NetAddress::dds({1});
const std::vector kBoth{PathKind::kUdp, PathKind::kDds};

// The paths to a router that answers after kRtt, over whichever path, what is asked at an address
// where it is reachable.
class PathsTest : public testing::Test {
 protected:
  PathsTest() { begin(); }

  void begin(const std::vector<PathKind>& preference = kBoth, Duration keep_alive = kKeepAlive) {
    paths = Paths();
    asked.clear();
    (void)paths.configure(now, preference, keep_alive);
    paths.set_targets(PathKind::kUdp, {&kUdp, 1});
    paths.set_targets(PathKind::kDds, {&kDds, 1});
    paths.begin(now, preference[0] == PathKind::kUdp ? kUdp : kDds);
  }
  // All that happens until then.
  void run_for(Duration time) {
    const Time end = now + time;
    while (next() <= end) {
      now = std::max(now, next());
      while (!answers.empty() && answers.front().at <= now) {
        const Answer answer = answers.front();
        answers.erase(answers.begin());
        changes += paths.on_answer(now, answer.question.to, answer.question.nonce) ? 1 : 0;
      }
      if (now >= paths.next_timeout(kRtt)) {
        changes += paths.on_timeout(now, kRtt) ? 1 : 0;
        ask();
        ASSERT_GT(paths.next_timeout(kRtt), now) << "it would be woken for ever";
      }
    }
    now = end;
  }
  void ask() {
    paths.ask(
        now, kRtt, [&] { return ++nonce; },
        [&](const Paths::Question& question) {
          asked.push_back({now, question});
          if (std::ranges::find(reachable, question.to) != reachable.end())
            answers.push_back({now + kRtt, question});
        });
  }
  void cut(const NetAddress& address) {
    std::erase(reachable, address);
    std::erase_if(answers, [&](const Answer& a) { return a.question.to == address; });
  }
  // Runs until the other path is used, and returns the time it took.
  Duration until(PathKind kind, Duration limit = 2min) {
    const Time start = now;
    while (paths.kind() != kind && now < start + limit) run_for(1ms);
    EXPECT_EQ(paths.kind(), kind);
    return now - start;
  }
  std::vector<Time> questions(const NetAddress& to) {
    std::vector<Time> times;
    for (const auto& [at, question] : asked)
      if (question.to == to) times.push_back(at);
    return times;
  }
  [[nodiscard]] bool works(PathKind kind) const { return paths.find(kind)->works; }
  [[nodiscard]] Time next() const {
    const Time timeout = paths.next_timeout(kRtt);
    return answers.empty() ? timeout : std::min(timeout, answers.front().at);
  }

  struct Answer {
    Time at{};
    Paths::Question question{};
  };
  Time now{100s};
  Paths paths;
  std::vector<NetAddress> reachable{kUdp, kDds};
  std::vector<Answer> asked;
  std::vector<Answer> answers;
  std::uint64_t nonce = 0;
  int changes = 0;
};

// --- which addresses are challenged, and when

TEST_F(PathsTest, WhatIsUsedIsAskedEveryKeepAliveAndTheOtherEverySecond) {
  run_for(60s);
  EXPECT_EQ(questions(kUdp).size(), 200U);
  EXPECT_EQ(questions(kDds).size(), 61U) << "and at once";
  EXPECT_EQ(changes, 0);
  EXPECT_EQ(paths.kind(), PathKind::kUdp);
}

TEST_F(PathsTest, NeitherIsAskedMoreOftenThanEveryKeepAlive) {
  begin(kBoth, 10s);
  run_for(60s);
  EXPECT_LE(asked.size(), 14U);
}

TEST_F(PathsTest, AnOverdueAnswerIsAskedForFourTimesAsOften) {
  run_for(300ms + kRtt);
  cut(kUdp);
  run_for(300ms - kRtt);  // asked again, and nothing comes
  asked.clear();
  run_for(290ms);
  const auto times = questions(kUdp);
  ASSERT_GE(times.size(), 3U);
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_EQ(times[i] - times[i - 1], 75ms);
}

TEST_F(PathsTest, ASinglePathIsNeverAsked) {
  begin({PathKind::kDds});
  cut(kDds);
  EXPECT_EQ(paths.next_timeout(kRtt), kNever);
  ask();
  EXPECT_TRUE(asked.empty());
  EXPECT_FALSE(paths.on_timeout(now + 1h, kRtt));
  EXPECT_TRUE(works(PathKind::kDds));
  EXPECT_EQ(paths.address(), kDds);
}

TEST_F(PathsTest, APathWithoutTargetsIsNotAsked) {
  paths.set_targets(PathKind::kDds, {});
  run_for(10s);
  EXPECT_TRUE(questions(kDds).empty());
}

TEST_F(PathsTest, AllPlacesAreAskedAndTheFirstToAnswerIsTaken) {
  const std::vector places{kMoved, kElsewhere};
  run_for(1s);
  paths.set_targets(PathKind::kUdp, places);
  reachable = {kDds, kMoved, kElsewhere};
  run_for(10s);
  EXPECT_FALSE(questions(kElsewhere).empty());
  EXPECT_EQ(paths.address(), kMoved);
  const auto before = questions(kElsewhere).size();
  run_for(10s);
  EXPECT_EQ(questions(kElsewhere).size(), before) << "where it was found, and nowhere else";
}

// --- which path is used

TEST_F(PathsTest, ADeadOneIsGivenUpAfterTwoKeepAlivesAndBeforeTheThird) {
  for (const Duration keep_alive : {50ms, 300ms, 10'000ms}) {
    begin(kBoth, keep_alive);
    reachable = {kUdp, kDds};
    run_for(5 * keep_alive + 1s);
    const Time answered = paths.find(PathKind::kUdp)->answered;
    cut(kUdp);
    until(PathKind::kDds);
    EXPECT_GE(now, answered + 2 * keep_alive);
    EXPECT_LE(now, answered + 2 * keep_alive + 2 * kRtt + 1ms);
  }
}

TEST_F(PathsTest, ALongRoundTripIsWaitedForButNotBeyondTheThirdKeepAlive) {
  cut(kUdp);
  const Time begun = now;
  EXPECT_FALSE(paths.on_timeout(begun + 649ms, 25ms));
  EXPECT_TRUE(works(PathKind::kUdp));
  EXPECT_FALSE(paths.on_timeout(begun + 749ms, 10s));
  EXPECT_TRUE(works(PathKind::kUdp));
  (void)paths.on_timeout(begun + 750ms, 10s);
  EXPECT_FALSE(works(PathKind::kUdp));
}

TEST_F(PathsTest, WhatArrivesIsAnAnswerToo) {
  run_for(1s);
  cut(kUdp);
  for (int i = 0; i < 50; ++i) {
    run_for(100ms);
    paths.on_arrived(now - kRtt);
  }
  EXPECT_EQ(changes, 0);
  const Time before = paths.since() - 1ms;
  for (int i = 0; i < 10; ++i) {
    run_for(100ms);
    paths.on_arrived(before);  // sent over another path
  }
  EXPECT_EQ(paths.kind(), PathKind::kDds);
}

TEST_F(PathsTest, OneThatStoodByIsGivenTimeToAnswerWhenItIsUsed) {
  run_for(10s);
  cut(kUdp);
  until(PathKind::kDds);
  EXPECT_TRUE(works(PathKind::kDds));
  (void)paths.on_timeout(now, kRtt);
  EXPECT_TRUE(works(PathKind::kDds));
  run_for(5s);
  EXPECT_TRUE(works(PathKind::kDds));
  EXPECT_EQ(changes, 1);
}

TEST_F(PathsTest, TheBetterOneIsTakenBackAfterThreeSecondsOfWork) {
  run_for(2s);
  cut(kUdp);
  run_for(10s);
  EXPECT_EQ(paths.kind(), PathKind::kDds);
  EXPECT_EQ(paths.why(), "udp has not answered for 620 ms");
  reachable.push_back(kUdp);
  const Duration took = until(PathKind::kUdp);
  EXPECT_GE(took, 3s);
  EXPECT_LE(took, 3s + 1s + kKeepAlive + kRtt);
  EXPECT_EQ(paths.why().substr(0, 16), "udp has worked f");
  EXPECT_EQ(paths.find(PathKind::kUdp)->answered, paths.since()) << "it works still";
}

TEST_F(PathsTest, OneThatComesAndGoesIsLeftAlone) {
  run_for(5s);
  for (int minute = 0; minute < 10; ++minute) {
    for (int i = 0; i < 60; i += 6) {
      cut(kUdp);
      run_for(1s);
      reachable.push_back(kUdp);
      run_for(5s);
    }
  }
  EXPECT_LE(changes, 6) << "and not two hundred";
  const Duration took = until(PathKind::kUdp);
  EXPECT_LE(took, Path::kProbationMax + kKeepAlive);
  run_for(2min);  // forgiven
  cut(kUdp);
  until(PathKind::kDds);
  reachable.push_back(kUdp);
  EXPECT_LE(until(PathKind::kUdp), 5s);
}

TEST_F(PathsTest, WhenAllAreDeadTheUsedOneIsStillAskedForAndComesBack) {
  run_for(2s);
  cut(kUdp);
  until(PathKind::kDds);
  cut(kDds);
  run_for(10s);
  EXPECT_FALSE(works(PathKind::kUdp));
  EXPECT_FALSE(works(PathKind::kDds));
  EXPECT_EQ(paths.kind(), PathKind::kDds);
  reachable = {kUdp};
  EXPECT_LE(until(PathKind::kUdp), 1s + kRtt + 1ms) << "at once: there is nothing else";
}

TEST_F(PathsTest, AfterASilenceAllAreAskedAnew) {
  run_for(2s);
  reachable = {kDds};
  paths.begin_again(now);
  EXPECT_FALSE(works(PathKind::kUdp));
  EXPECT_FALSE(works(PathKind::kDds));
  EXPECT_EQ(paths.address(), kUdp) << "until something else is known";
  EXPECT_LE(until(PathKind::kDds), kRtt + 1ms);
}

TEST_F(PathsTest, ANewSessionKnowsNothingOfTheOtherPaths) {
  run_for(5s);
  EXPECT_TRUE(works(PathKind::kUdp));
  paths.begin(now, kDds);
  EXPECT_EQ(paths.kind(), PathKind::kDds);
  EXPECT_FALSE(works(PathKind::kUdp));
  EXPECT_FALSE(paths.find(PathKind::kUdp)->address) << "another router's, perhaps";
  EXPECT_GE(until(PathKind::kUdp), 3s) << "it is asked where it should be";
}

// --- answers

TEST_F(PathsTest, ANonceThatNobodyAskedOrThatWasAnsweredIsNothing) {
  EXPECT_FALSE(paths.on_answer(now, kDds, 77));
  EXPECT_FALSE(paths.on_answer(now, kDds, 0));
  EXPECT_FALSE(works(PathKind::kDds));
  reachable = {};
  run_for(1ms);
  ASSERT_EQ(asked.size(), 1U);
  const Paths::Question question = asked[0].question;
  (void)paths.on_answer(now, kDds, question.nonce);
  EXPECT_TRUE(works(PathKind::kDds));
  paths.begin_again(now);
  (void)paths.on_answer(now, kDds, question.nonce);
  EXPECT_FALSE(works(PathKind::kDds));
  EXPECT_FALSE(works(PathKind::kUdp));
}

TEST_F(PathsTest, AKnownAddressMayBeAnsweredOnAnyPath) {
  reachable = {};
  run_for(1ms);
  ASSERT_EQ(asked[0].question.to, kDds);
  (void)paths.on_answer(now, kUdp, asked[0].question.nonce);
  EXPECT_TRUE(works(PathKind::kDds));
  EXPECT_EQ(paths.find(PathKind::kDds)->address, kDds);
}

TEST_F(PathsTest, AnAddressSeenAsASourceMustAnswerItself) {
  const auto question = paths.on_source(now, kMoved, 5);
  ASSERT_TRUE(question);
  EXPECT_FALSE(paths.on_answer(now, kUdp, 5));
  EXPECT_FALSE(paths.on_answer(now, kElsewhere, 5));
  EXPECT_EQ(paths.address(), kUdp);
  EXPECT_TRUE(paths.on_answer(now, kMoved, 5));
  EXPECT_EQ(paths.address(), kMoved);
  EXPECT_FALSE(paths.on_answer(now, kMoved, 5));
}

TEST_F(PathsTest, AStrangeAddressIsAskedTenTimesASecondAtMost) {
  EXPECT_FALSE(paths.on_source(now, kUdp, 1)) << "known";
  EXPECT_TRUE(paths.on_source(now, kMoved, 2));
  EXPECT_FALSE(paths.on_source(now + 99ms, kMoved, 3));
  EXPECT_TRUE(paths.on_source(now + 100ms, kMoved, 4));
  begin({PathKind::kUdp});
  EXPECT_FALSE(paths.on_source(now, kDds, 5)) << "not a path of this link";
}

TEST_F(PathsTest, ALateAnswerFromWhereItWasDoesNotMoveItBack) {
  run_for(310ms - 2 * kRtt + 1ms);
  reachable = {};
  ask();
  run_for(20ms);
  ASSERT_EQ(asked.back().question.to, kUdp);
  const Paths::Question late = asked.back().question;
  ASSERT_TRUE(paths.on_source(now, kMoved, 1000));
  ASSERT_TRUE(paths.on_answer(now, kMoved, 1000));
  EXPECT_FALSE(paths.on_answer(now, kUdp, late.nonce));
  EXPECT_EQ(paths.address(), kMoved);
}

// --- where it is called

TEST_F(PathsTest, TheFirstPathWithTargetsIsCalledFirst) {
  EXPECT_EQ(paths.to_call(true), std::vector{kUdp});
  EXPECT_EQ(paths.to_call(false), (std::vector{kUdp, kDds}));
  paths.set_targets(PathKind::kUdp, {});
  EXPECT_EQ(paths.to_call(true), std::vector{kDds});
  EXPECT_TRUE(paths.has_targets());
  EXPECT_FALSE(paths.is_target(kUdp));
  (void)paths.on_source(now, kMoved, 1);
  EXPECT_EQ(paths.to_call(true), std::vector{kMoved})
      << "also the address it was last reachable at";
  paths.set_targets(PathKind::kDds, {});
  EXPECT_FALSE(paths.has_targets());
}

TEST_F(PathsTest, AnAddressThatHasNotAnsweredIsAStranger) {
  EXPECT_FALSE(paths.is_strange(kUdp));
  EXPECT_TRUE(paths.is_strange(kDds));
  EXPECT_TRUE(paths.is_at(kUdp));
  EXPECT_FALSE(paths.is_at(kDds));
  run_for(1s);
  EXPECT_FALSE(paths.is_strange(kDds));
  EXPECT_TRUE(paths.is_at(kDds));
}

// --- configuration, counters

TEST_F(PathsTest, PathsThatStayKeepTheirState) {
  run_for(5s);
  paths.count_in(PathKind::kDds, 100);
  const std::vector turned{PathKind::kDds, PathKind::kUdp};
  EXPECT_FALSE(paths.configure(now, turned, kKeepAlive));
  EXPECT_EQ(paths.kind(), PathKind::kUdp);
  EXPECT_TRUE(works(PathKind::kDds));
  EXPECT_EQ(paths.find(PathKind::kDds)->counters.bytes_in, 100U);
  run_for(kKeepAlive + kRtt);
  EXPECT_EQ(paths.kind(), PathKind::kDds) << "preferred now, and has worked for long";
  EXPECT_EQ(changes, 1);
}

TEST_F(PathsTest, WhenTheUsedOneIsTakenAwayTheOtherIsUsed) {
  run_for(5s);
  const std::vector dds{PathKind::kDds};
  EXPECT_TRUE(paths.configure(now, dds, kKeepAlive));
  EXPECT_EQ(paths.address(), kDds);
  EXPECT_EQ(paths.find(PathKind::kUdp), nullptr);
  EXPECT_EQ(paths.since(), now);
}

TEST_F(PathsTest, EachPathIsCounted) {
  paths.count_in(PathKind::kUdp, 10);
  paths.count_in(PathKind::kUdp, 20);
  paths.count_out(PathKind::kDds, 5);
  for (const auto& [kind, in, out] :
       {std::tuple(PathKind::kUdp, 2U, 0U), {PathKind::kDds, 0U, 1U}}) {
    const PathCounters& counters = paths.find(kind)->counters;
    EXPECT_EQ(counters.datagrams_in, in);
    EXPECT_EQ(counters.bytes_in, 15 * in);
    EXPECT_EQ(counters.datagrams_out, out);
    EXPECT_EQ(counters.bytes_out, 5 * out);
  }
}

TEST_F(PathsTest, APathWithoutTargetsLeadsNowhereUntilAPeerWasThere) {
  EXPECT_TRUE(paths.leads(PathKind::kDds));
  paths.set_targets(PathKind::kDds, {});
  EXPECT_FALSE(paths.leads(PathKind::kDds));
  paths.set_targets(PathKind::kUdp, {});
  EXPECT_TRUE(paths.leads(PathKind::kUdp));
}

}  // namespace paths_test
}  // namespace tims::link
