#include "router/link/path_mtu.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace tims::link
