// A simple test device: each byte produces a data set with the sum of all bytes so far, a timeout
// produces the sum once more, and byte FF changes the baud rate.
#include "rack/devices/replay.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace replay_test {

using namespace std::chrono_literals;

class Adder final : public Dialogue {
 public:
  explicit Adder(int step) : step_(step) {}
  void start(Time now, Output&) override { began_ = now; }
  void on_arrival(const Arrival& arrival, Output& out) override {
    for (const std::byte byte : arrival.bytes) {
      if (byte == std::byte{0xFF}) return out.set_baud(9600);
      sum_ += step_ * std::to_integer<int>(byte);
    }
    measured_ = arrival.first;
    has_sum_ = true;
  }
  void on_timeout(Time now, Output&) override {
    measured_ = now;
    has_sum_ = true;
  }
  bool take(std::vector<std::byte>& sum, Time& measured) {
    if (!std::exchange(has_sum_, false)) return false;
    sum = {static_cast<std::byte>(sum_ >> 8), static_cast<std::byte>(sum_)};
    measured = measured_;
    return true;
  }
  [[nodiscard]] Time began() const { return began_; }

 private:
  int step_;
  int sum_ = 0;
  bool has_sum_ = false;
  Time measured_{};
  Time began_{};
};

// Records like a driver, with a clock that the test controls.
class ReplayTest : public testing::Test, private Output {
 protected:
  void open(Duration at) {
    adder_.emplace(1);
    conversation_.emplace(*adder_, [this] { return note_made(); });
    records_ = 0;
    note({.time = at, .direction = Direction::kStarted});
    conversation_->start(Time(at), *this);
  }
  void receive(Duration at, Duration took, std::vector<std::byte> bytes) {
    note({.time = at, .took = took, .bytes = std::move(bytes)});
    conversation_->receive(
        {.bytes = recording_.back().bytes, .first = Time(at - took), .last = Time(at)}, *this);
  }
  void on_timeout(Duration at) {
    note({.time = at, .direction = Direction::kTime});
    conversation_->on_timeout(Time(at), *this);
  }
  void drive() {
    open(0ns);
    receive(5ms, 1ms, {std::byte{1}, std::byte{2}});
    on_timeout(7ms + 3ns);
    receive(9ms, 2ms, std::vector(100, std::byte{9}));
    receive(11ms, 0ns, {std::byte{0xFF}, std::byte{1}});
    open(1s);
    receive(1s + 3ms, 1ms, {std::byte{4}});
  }

  // Replays with a driver that adds `step`.
  void replay(int step = 1) {
    std::optional<Adder> again;
    std::vector<std::byte> sum;
    replay_.emplace([&] {
      again.emplace(step);
      return tims::Result(Replay::Side{&*again, [&]() -> tims::Result<void> {
                                         for (Time measured{}; again->take(sum, measured);)
                                           replay_->made(measured, sum);
                                         return {};
                                       }});
    });
    for (const CaptureRecord& record : recording_) {
      ASSERT_TRUE(replay_->take(record));
      EXPECT_NE(again->began(), Time{}) << "dialogues use Time{} for 'not set'";
    }
  }

  std::vector<CaptureRecord> recording_;
  std::optional<Replay> replay_;

 private:
  void note(CaptureRecord record) {
    ++records_;
    recording_.push_back(std::move(record));
  }
  tims::Result<void> note_made() {
    std::vector<std::byte> sum;
    for (Time measured{}; adder_->take(sum, measured);) {
      const Checksum checksum = checksum_of(sum);
      recording_.push_back({.time = measured.time_since_epoch(),
                            .direction = Direction::kMade,
                            .id = records_,
                            .bytes = {checksum.begin(), checksum.end()}});
    }
    return {};
  }
  void send(std::span<const std::byte>, std::uint32_t) override {}
  void set_baud(std::uint32_t) override { conversation_->drop_rest(); }

  std::optional<Adder> adder_;
  std::optional<Conversation> conversation_;
  std::uint32_t records_ = 0;
};

TEST_F(ReplayTest, TheSameIsMadeAgain) {
  drive();
  replay();
  EXPECT_EQ(replay_->openings(), 2U);
  // 100 bytes arrive in slices of 16; the two received at a different rate produce nothing.
  EXPECT_EQ(replay_->messages(), 1U + 1U + 7U + 1U);
  EXPECT_EQ(replay_->different(), 0U);
  EXPECT_EQ(replay_->lost(), 0U);
  EXPECT_TRUE(replay_->is_same());
  EXPECT_EQ(replay_->report(), "10 data sets replayed: 0 different\n");
}

TEST_F(ReplayTest, OtherDataAreSeen) {
  drive();
  replay(2);
  EXPECT_EQ(replay_->different(), replay_->messages());
  ASSERT_TRUE(replay_->first_difference());
  EXPECT_EQ(replay_->first_difference()->at, 4ms) << "when it was measured";
}

TEST_F(ReplayTest, AnotherTimeOfMeasurementIsSeen) {
  drive();
  for (CaptureRecord& record : recording_)
    if (record.direction == Direction::kTime) record.time += 1ns;
  replay();
  EXPECT_EQ(replay_->different(), 1U);
  EXPECT_NE(replay_->first_difference()->text.find(" 1 ns later"), std::string::npos)
      << replay_->first_difference()->text;
}

TEST_F(ReplayTest, WhatIsMadeOnlyThenOrOnlyNowIsSeen) {
  drive();
  const auto made = std::ranges::find(recording_, Direction::kMade, &CaptureRecord::direction);
  const CaptureRecord twice = *made;
  recording_.insert(made, twice);
  replay();
  EXPECT_EQ(replay_->different(), 1U);
  EXPECT_EQ(replay_->messages(), 11U);

  std::erase_if(recording_, [&](const CaptureRecord& record) { return record.time == twice.time; });
  replay();
  EXPECT_EQ(replay_->different(), 1U);
  EXPECT_EQ(replay_->messages(), 10U);
}

// When the disk was full: records after the gap are not compared until the device is opened again.
TEST_F(ReplayTest, NothingIsComparedWhereRecordsAreMissing) {
  drive();
  std::erase_if(recording_,
                [](const CaptureRecord& record) { return record.direction == Direction::kTime; });
  replay();
  EXPECT_EQ(replay_->different(), 0U);
  EXPECT_EQ(replay_->messages(), 2U) << "one before the gap, one after the second opening";
  EXPECT_EQ(replay_->lost(), 8U);
  EXPECT_FALSE(replay_->is_same());
}

TEST_F(ReplayTest, OfWhatNoDriverHasRecordedNothingIsMade) {
  recording_ = {{.time = 1ms, .bytes = {std::byte{1}}}, {.direction = Direction::kSent}};
  Replay replay([]() -> tims::Result<Replay::Side> {
    ADD_FAILURE() << "nothing was opened";
    return tims::Error(tims::Errc::kInvalidArgument, "");
  });
  for (const CaptureRecord& record : recording_) EXPECT_TRUE(replay.take(record));
  EXPECT_EQ(replay.openings() + replay.messages() + replay.lost(), 0U);
}

}  // namespace replay_test
}  // namespace rack::device
