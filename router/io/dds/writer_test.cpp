#include "router/io/dds/writer.h"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "router/link/transport.h"

namespace tims::io {
namespace writer_test {

using Bytes = std::vector<std::byte>;

link::Burst burst(const Bytes& bytes, std::size_t datagram_size) {
  return {.bytes = bytes, .datagram_size = datagram_size};
}

Bytes joined(const SendQueue::Front& front) {
  Bytes bytes(front.parts[0].begin(), front.parts[0].end());
  bytes.insert(bytes.end(), front.parts[1].begin(), front.parts[1].end());
  return bytes;
}

// The sizes of the datagrams that are taken.
std::string take(SendQueue& queue, std::size_t bytes_max) {
  const auto front = queue.front(bytes_max);
  Bytes bytes = joined(front);
  EXPECT_EQ(bytes.size(), front.bytes);
  std::string sizes;
  if (link::Batch(bytes).valid())
    link::Batch(bytes).for_each([&](auto d) { sizes += std::to_string(d.size()) + " "; });
  queue.remove(front);
  return sizes;
}

TEST(SendQueue, ABurstIsTakenAsDatagrams) {
  SendQueue queue(1000);
  EXPECT_EQ(take(queue, 1000), "");
  EXPECT_TRUE(queue.put(burst(Bytes(25), 10)));
  EXPECT_EQ(queue.waiting_bytes(), 25 + 3 * link::kBatchSizeBytes);
  EXPECT_EQ(take(queue, 1000), "10 10 5 ");
  EXPECT_EQ(queue.waiting_bytes(), 0);
}

TEST(SendQueue, WholeDatagramsAsManyAsHaveRoom) {
  SendQueue queue(1000);
  ASSERT_TRUE(queue.put(burst(Bytes(50), 10)));
  EXPECT_EQ(take(queue, 35), "10 10 ");
  EXPECT_EQ(take(queue, 36), "10 10 10 ");
  ASSERT_TRUE(queue.put(burst(Bytes(100), 100)));
  EXPECT_EQ(take(queue, 50), "100 ") << "one that is larger goes alone";
}

TEST(SendQueue, AllOfABurstOrNothing) {
  SendQueue queue(100);
  EXPECT_TRUE(queue.put(burst(Bytes(48), 48)));
  EXPECT_FALSE(queue.put(burst(Bytes(49), 49)));
  EXPECT_FALSE(queue.put(burst(Bytes(48), 24))) << "no room for the second size";
  EXPECT_TRUE(queue.put(burst(Bytes(48), 48)));
  EXPECT_EQ(take(queue, 1000), "48 48 ");
  EXPECT_FALSE(queue.put(burst(Bytes(99), 99)));
}

TEST(SendQueue, AnEmptyBurstIsNothing) {
  SendQueue queue(100);
  EXPECT_TRUE(queue.put({}));
  EXPECT_EQ(take(queue, 100), "");
}

// Everything that was put is taken, in order, wherever the ring ends.
TEST(SendQueue, GoesRoundItsRing) {
  constexpr int kDatagrams = 2'000;
  SendQueue queue(997);
  std::minstd_rand random(1);
  int put = 0;
  for (int next = 0; next < kDatagrams;) {
    const Bytes bytes(1 + random() % 200, static_cast<std::byte>(put));
    if (put < kDatagrams && queue.put(burst(bytes, bytes.size()))) {
      ++put;
      continue;
    }
    const auto front = queue.front(300);
    Bytes taken = joined(front);
    ASSERT_TRUE(link::Batch(taken).valid());
    link::Batch(taken).for_each([&](auto datagram) {
      EXPECT_EQ(datagram.front(), static_cast<std::byte>(next));
      EXPECT_EQ(datagram.back(), static_cast<std::byte>(next));
      ++next;
    });
    queue.remove(front);
  }
  EXPECT_EQ(queue.waiting_bytes(), 0);
}

}  // namespace writer_test

}  // namespace tims::io
