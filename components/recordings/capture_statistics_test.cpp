#include "components/recordings/capture_statistics.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace capture_statistics_test {

using namespace std::chrono_literals;

CaptureRecord record(Duration time, std::size_t size, std::uint32_t id = 0,
                     Direction direction = Direction::kReceived) {
  return {.time = time,
          .direction = direction,
          .id = id,
          .bytes = std::vector<std::byte>(size),
          .event = {}};
}

TEST(CaptureStatisticsTest, NothingIsNothing) {
  const CaptureStatistics statistics;
  EXPECT_EQ(statistics.received().records, 0U);
  EXPECT_EQ(statistics.duration(), 0s);
  EXPECT_EQ(statistics.longest_gap(), 0s);
}

TEST(CaptureStatisticsTest, BothDirectionsAndHowLong) {
  CaptureStatistics statistics;
  statistics.add(record(100s, 8, 0, Direction::kSent));
  statistics.add(record(101s, 5));
  statistics.add(record(104s, 6));
  EXPECT_EQ(statistics.sent().bytes, 8U);
  EXPECT_EQ(statistics.received().records, 2U);
  EXPECT_EQ(statistics.received().bytes, 11U);
  EXPECT_EQ(statistics.duration(), 4s);
  EXPECT_EQ(statistics.longest_gap(), 3s);
  EXPECT_EQ(statistics.longest_gap_at(), 1s) << "since the first record";
}

TEST(CaptureStatisticsTest, AGapIsMuchLongerThanUsual) {
  CaptureStatistics statistics;
  Duration time{};
  for (int i = 0; i < 100; ++i) statistics.add(record(time += 13ms, 4));
  EXPECT_EQ(statistics.gaps(), 0U);
  statistics.add(record(time += 500ms, 4));
  for (int i = 0; i < 100; ++i) statistics.add(record(time += 13ms, 4));
  EXPECT_EQ(statistics.gaps(), 1U);
  EXPECT_EQ(statistics.longest_gap(), 500ms);
}

TEST(CaptureStatisticsTest, FramesByTheirIdentifiersUpToALimit) {
  CaptureStatistics statistics;
  for (std::uint32_t id = 1; id <= CaptureStatistics::kIdsMax + 10; ++id)
    statistics.add(record(Duration(id), 8, id));
  statistics.add(record(1s, 8, 1));
  EXPECT_EQ(statistics.by_id().size(), CaptureStatistics::kIdsMax);
  EXPECT_EQ(statistics.by_id().at(1).records, 2U);
  EXPECT_EQ(statistics.received().records, CaptureStatistics::kIdsMax + 11);
}

TEST(CaptureStatisticsTest, EventsAndTimesThatGoBack) {
  CaptureStatistics statistics;
  statistics.add(record(5s, 1));
  CaptureRecord event = record(6s, 0, 0, Direction::kEvent);
  event.event = "the device is gone";
  statistics.add(event);
  statistics.add(record(4s, 1));
  ASSERT_EQ(statistics.events().size(), 1U);
  EXPECT_EQ(statistics.events()[0].time, 1s);
  EXPECT_EQ(statistics.backwards(), 1U);
  EXPECT_EQ(statistics.duration(), 1s);
  for (std::size_t i = 0; i < 2 * CaptureStatistics::kEventsMax; ++i) statistics.add(event);
  EXPECT_EQ(statistics.events().size(), CaptureStatistics::kEventsMax);
  EXPECT_EQ(statistics.event_count(), 2 * CaptureStatistics::kEventsMax + 1);
}

}  // namespace capture_statistics_test
}  // namespace rack::device
