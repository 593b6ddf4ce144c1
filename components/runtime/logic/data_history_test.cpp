#include "rack/data_history.h"

#include <cstring>

#include <gtest/gtest.h>

namespace rack {
namespace data_history_test {

using namespace std::chrono_literals;
using Miss = DataHistory::Miss;

// Data sets of four bytes, 100 ms apart: what is in them is their time stamp.
class History : public testing::TestWithParam<std::uint32_t> {
 protected:
  static constexpr std::uint32_t kPlaces = 5;

  void publish(std::uint32_t after) {
    const std::uint32_t stamp = GetParam() + after;
    std::memcpy(history_.workspace().data(), &stamp, sizeof stamp);
    history_.publish(stamp, sizeof stamp);
  }
  static std::uint32_t after(const DataHistory::Entry& entry) {
    std::uint32_t stamp = 0;
    std::memcpy(&stamp, entry.body.data(), sizeof stamp);
    EXPECT_EQ(stamp, entry.recorded.raw());
    return stamp - GetParam();
  }
  // The data set nearest to a time, as milliseconds after the first.
  [[nodiscard]] std::int64_t nearest(std::int32_t time) const {
    const auto found = history_.nearest(GetParam() + static_cast<std::uint32_t>(time), 200ms);
    if (const auto* miss = std::get_if<Miss>(&found)) return -1 - static_cast<int>(*miss);
    return after(std::get<DataHistory::Entry>(found));
  }

  DataHistory history_{kPlaces, 8};
};

constexpr std::int64_t kEmpty = -1 - static_cast<int>(Miss::kEmpty);
constexpr std::int64_t kTooOld = -1 - static_cast<int>(Miss::kTooOld);
constexpr std::int64_t kTooNew = -1 - static_cast<int>(Miss::kTooNew);

// At an ordinary time, and at the wrap of the 32 bits.
INSTANTIATE_TEST_SUITE_P(Days, History, testing::Values(1'000'000, 0xFFFF'FF06, 0x7FFF'FF06));

TEST_P(History, IsEmptyAtFirst) { EXPECT_EQ(nearest(0), kEmpty); }

TEST_P(History, FindsTheNearest) {
  for (const std::uint32_t at : {0, 100, 200}) publish(at);
  EXPECT_EQ(nearest(-1), kTooOld);
  EXPECT_EQ(nearest(0), 0);
  EXPECT_EQ(nearest(49), 0);
  EXPECT_EQ(nearest(50), 100) << "of two the later";
  EXPECT_EQ(nearest(100), 100);
  EXPECT_EQ(nearest(170), 200);
  EXPECT_EQ(nearest(400), 200);
  EXPECT_EQ(nearest(401), kTooNew);
}

TEST_P(History, ForgetsTheOldest) {
  for (std::uint32_t at = 0; at <= 1000; at += 100) publish(at);
  EXPECT_EQ(history_.size(), kPlaces - 1) << "one place is the workspace";
  EXPECT_EQ(after(history_.newest()), 1000U);
  EXPECT_EQ(after(history_.oldest()), 700U);
  EXPECT_EQ(nearest(699), kTooOld);
  EXPECT_EQ(nearest(700), 700);
  history_.clear();
  EXPECT_EQ(nearest(700), kEmpty);
}

TEST_P(History, TheWorkspaceIsNotAmongThem) {
  for (std::uint32_t at = 0; at <= 1000; at += 100) publish(at);
  std::memset(history_.workspace().data(), 0xEE, history_.workspace().size());
  for (std::int32_t at = 700; at <= 1000; at += 100) EXPECT_EQ(nearest(at), at);
}

TEST_P(History, KnowsTheNeighboursOfATime) {
  for (const std::uint32_t at : {0, 100, 200}) publish(at);
  const auto around = [&](std::uint32_t time) {
    const auto pair = std::get<DataHistory::Pair>(history_.around(GetParam() + time, 100ms));
    return std::pair(after(pair.before), after(pair.after));
  };
  EXPECT_EQ(around(0), std::pair(0U, 100U));
  EXPECT_EQ(around(30), std::pair(0U, 100U));
  EXPECT_EQ(around(100), std::pair(100U, 200U));
  EXPECT_EQ(around(250), std::pair(100U, 200U)) << "beyond the newest: where the last two lead";
  EXPECT_EQ(std::get<Miss>(history_.around(GetParam() + 301, 100ms)), Miss::kTooNew);
}

TEST_P(History, OneDataSetIsItsOwnNeighbour) {
  publish(0);
  const auto pair = std::get<DataHistory::Pair>(history_.around(GetParam(), 100ms));
  EXPECT_EQ(after(pair.before), 0U);
  EXPECT_EQ(after(pair.after), 0U);
}

}  // namespace data_history_test
}  // namespace rack
