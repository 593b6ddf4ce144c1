// What is learnt about a path: its MTU, its clock, its rate; and the bad network that tests use.
#include <gtest/gtest.h>

#include "router/link/clock_offset.h"
#include "router/link/congestion.h"
#include "router/link/impairment.h"
#include "router/link/path_mtu.h"
#include "router/link/token_bucket.h"

namespace tims::link {
namespace {

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
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(mtu.on_lost(now, 1472));
  mtu.on_acked(1472);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(mtu.on_lost(now, 1472));
  EXPECT_FALSE(mtu.on_lost(now, 1200));
  EXPECT_TRUE(mtu.on_lost(now, 1472));
  EXPECT_EQ(mtu.size(), kDatagramBase);
}

TEST(ClockOffset, TheShortestRoundTripCounts) {
  ClockOffset clock;
  EXPECT_FALSE(clock.best().has_value());
  clock.add(1000, 6000, 6100, 9100);  // on the way back something waited
  clock.add(20'000, 25'010, 25'020, 20'030);
  ASSERT_TRUE(clock.best().has_value());
  EXPECT_EQ(clock.best()->offset, 5000);
  EXPECT_EQ(clock.best()->round_trip, 20);
  clock.add(INT64_MIN, INT64_MAX, INT64_MIN, INT64_MAX);  // whatever they say
}

TEST(TokenBucket, LetsItsRateThrough) {
  TokenBucket bucket;
  EXPECT_TRUE(bucket.ready(Time{1s}));
  bucket.set(1'000'000, 2000);
  Time now{1s};
  std::uint64_t bytes = 0;
  while (now < Time{3s}) {
    now = bucket.ready_at(now);
    EXPECT_TRUE(bucket.ready(now));
    bucket.take(1000);
    bytes += 1000;
  }
  EXPECT_NEAR(static_cast<double>(bytes), 2'000'000, 5000);
}

// One round of packets, all acknowledged after the same time.
void round(Congestion& congestion, Time& now, Duration rtt, std::uint64_t& packet,
           std::uint32_t lost = 0) {
  const std::uint64_t bytes = congestion.window();
  const auto packets = static_cast<std::uint32_t>(bytes / 1200);
  now += rtt;
  const std::uint64_t newest = packet + packets;
  congestion.on_feedback(now, {.rtt = rtt,
                               .bytes_acked = bytes * (packets - lost) / packets,
                               .packets_acked = packets - lost,
                               .packets_lost = lost,
                               .newest_acked = newest,
                               .next_packet = newest + 1,
                               .in_flight = bytes});
  packet = newest + 1;
}

TEST(Congestion, DoublesUntilAQueueBuildsUp) {
  Congestion congestion(1200);
  Time now{1s};
  std::uint64_t packet = 0;
  const std::uint64_t first = congestion.window();
  for (int i = 0; i < 5; ++i) round(congestion, now, 10ms, packet);
  EXPECT_EQ(congestion.window(), 32 * first);
  round(congestion, now, 30ms, packet);
  EXPECT_LT(congestion.window(), 16 * first);
}

TEST(Congestion, ALittleLossIsTheMediums) {
  Congestion congestion(1200);
  Time now{1s};
  std::uint64_t packet = 0;
  for (int i = 0; i < 4; ++i) round(congestion, now, 10ms, packet, 1);
  EXPECT_GT(congestion.window(), 100'000U);
}

TEST(Congestion, MuchLossIsNot) {
  Congestion congestion(1200);
  Time now{1s};
  std::uint64_t packet = 0;
  for (int i = 0; i < 5; ++i) round(congestion, now, 10ms, packet);
  const std::uint64_t before = congestion.window();
  for (int i = 0; i < 3; ++i)
    round(congestion, now, 10ms, packet, static_cast<std::uint32_t>(congestion.window() / 2400));
  EXPECT_LT(congestion.window(), before);
}

TEST(Congestion, SilenceBeginsAnew) {
  Congestion congestion(1200);
  congestion.on_silence();
  EXPECT_EQ(congestion.window(), 4 * 1200U);
}

TEST(Impairment, LosesItsShare) {
  Impairment line(1);
  line.set({.loss = 0.3});
  int lost = 0;
  for (int i = 0; i < 10'000; ++i) lost += line.send(Time{1s}, 100).count == 0 ? 1 : 0;
  EXPECT_NEAR(lost, 3000, 150);
}

TEST(Impairment, KeepsARateAndAQueue) {
  Impairment line(1);
  line.set({.rate = 1'000'000, .queue = 10'000});
  int through = 0;
  Time last{};
  for (int i = 0; i < 100; ++i) {
    const auto fate = line.send(Time{1s}, 1000 - 42);
    through += static_cast<int>(fate.count);
    if (fate.count > 0) last = fate.at[0];
  }
  EXPECT_EQ(through, 11);
  EXPECT_EQ(last, Time{1s} + 11ms);
}

TEST(Impairment, CarriesWhatItsMtuAllows) {
  Impairment line(1);
  line.set({.mtu = 1200});
  EXPECT_EQ(line.send(Time{1s}, 1200).count, 1U);
  EXPECT_EQ(line.send(Time{1s}, 1201).count, 0U);
  line.set({.blackout = true});
  EXPECT_EQ(line.send(Time{1s}, 1).count, 0U);
}

}  // namespace
}  // namespace tims::link
