#include "router/link/congestion.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace congestion_test {

using namespace std::chrono_literals;

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
  const auto lose_half = [&](int rounds) {
    for (int i = 0; i < rounds; ++i)
      round(congestion, now, 10ms, packet, static_cast<std::uint32_t>(congestion.window() / 2400));
  };
  lose_half(3);
  EXPECT_LT(congestion.window(), before);
  lose_half(30);
  EXPECT_LT(congestion.window(), 10 * 1200U) << "it goes on falling";
}

TEST(Congestion, SilenceBeginsAnew) {
  Congestion congestion(1200);
  congestion.on_silence();
  EXPECT_EQ(congestion.window(), 4 * 1200U);
}

}  // namespace congestion_test
}  // namespace tims::link
