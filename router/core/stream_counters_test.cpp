#include "router/core/stream_counters.h"

#include <gtest/gtest.h>

namespace tims::core {
namespace stream_counters_test {

Header sample(std::uint32_t src, std::uint32_t dest = 9, std::int8_t type = -6) {
  return {.flags = flag::kStream, .type = type, .dest = Address(dest), .src = Address(src)};
}

std::size_t count(const StreamCounters& counters) {
  std::size_t streams = 0;
  counters.for_each([&](const StreamCounters::Stream&) { ++streams; });
  return streams;
}

TEST(StreamCounters, AStreamIsASourceADestinationAndAType) {
  StreamCounters counters;
  for (const Header& header : {sample(1), sample(1), sample(2), sample(1, 8), sample(1, 9, -7)})
    counters.add(header);
  Header other = sample(3);
  other.flags = 0;
  counters.add(other);
  EXPECT_EQ(count(counters), 4U);
  counters.drop(sample(1));
  counters.drop(sample(77));
  counters.for_each([](const StreamCounters::Stream& stream) {
    const bool first = stream.src == Address(1) && stream.dest == Address(9) && stream.type == -6;
    EXPECT_EQ(stream.samples, first ? 2U : 1U);
    EXPECT_EQ(stream.dropped, first ? 1U : 0U);
  });
}

TEST(StreamCounters, KnowsWhatWaits) {
  StreamCounters counters;
  counters.add(sample(1));
  EXPECT_FALSE(counters.has_waiting(sample(1)));
  counters.waits(sample(1));
  EXPECT_TRUE(counters.has_waiting(sample(1)));
  EXPECT_FALSE(counters.has_waiting(sample(2)));
  counters.left(sample(1));
  counters.left(sample(1));
  EXPECT_FALSE(counters.has_waiting(sample(1)));
}

TEST(StreamCounters, ForgetsStreamsWithoutSamplesFirst) {
  StreamCounters counters;
  for (std::uint32_t i = 0; i < 10000; ++i) {
    counters.add(sample(100 + i));
    counters.add(sample(1));
  }
  EXPECT_EQ(count(counters), StreamCounters::kStreamsMax);
  counters.for_each([](const StreamCounters::Stream& stream) {
    if (stream.src == Address(1)) {
      EXPECT_EQ(stream.samples, 10000U);
    }
  });
}

}  // namespace stream_counters_test
}  // namespace tims::core
