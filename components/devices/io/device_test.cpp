// Device with a dialogue: data received together are passed in slices, and results are taken after
// each slice.
#include "rack/devices/device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/eventfd.h>

#include "components/devices/io/transports.h"
#include "os/clock.h"
#include "os/file.h"

namespace rack::device {
namespace device_test {

using namespace std::chrono_literals;
using testing::ElementsAre;

// A transport that delivers the arrivals given by the test, all in the next wait().
class Given final : public Transport {
 public:
  explicit Given(std::vector<Arrival>& arrivals) : arrivals_(arrivals) {}

  [[nodiscard]] int descriptor() const override { return ready_.get(); }
  [[nodiscard]] std::string description() const override { return "given"; }
  tims::Result<void> receive(Time, const Receive& receive) override {
    for (const Arrival& arrival : std::exchange(arrivals_, {})) receive(arrival);
    return {};
  }
  tims::Result<bool> send(Time, std::span<const std::byte>, std::uint32_t) override { return true; }

 private:
  std::vector<Arrival>& arrivals_;
  tims::os::File ready_{::eventfd(1, EFD_CLOEXEC)};
};

// Telegrams are 16 bit big-endian numbers; as in real dialogues, only the last one is stored.
class Numbers final : public Dialogue {
 public:
  void start(Time, Output&) override {}
  void on_arrival(const Arrival& arrival, Output&) override {
    pieces.push_back(arrival);
    for (const std::byte byte : arrival.bytes) {
      if (!half_) {
        half_ = std::to_integer<int>(byte);
        continue;
      }
      number_ = *std::exchange(half_, {}) * 256 + std::to_integer<int>(byte);
      if (number_ == kNonsense) fail(tims::Errc::kMalformed, "nonsense");
    }
  }
  void on_sent(const Arrival& arrival) override { sent.push_back(arrival); }
  std::optional<int> take() { return std::exchange(number_, {}); }

  static constexpr int kNonsense = 0xFFFF;

  std::vector<Arrival> pieces;
  std::vector<Arrival> sent;

 private:
  std::optional<int> half_;
  std::optional<int> number_;
};

std::vector<std::byte> telegrams_with_filling(std::initializer_list<int> numbers) {
  std::vector<std::byte> all;
  for (const int number : numbers)
    for (int i = 0; i < 8; ++i) {  // 16 bytes: no telegram with data is shorter
      all.push_back(static_cast<std::byte>(number >> 8));
      all.push_back(static_cast<std::byte>(number));
    }
  return all;
}

class DeviceTest : public testing::Test {
 protected:
  std::unique_ptr<Device> device() {
    return Device::with(std::make_unique<Given>(given_), dialogue_, [this]() -> tims::Result<void> {
      if (const auto number = dialogue_.take()) taken_.push_back(*number);
      if (error_) return *error_;
      return {};
    });
  }

  std::vector<Arrival> given_;
  Numbers dialogue_;
  std::vector<int> taken_;
  std::optional<tims::Error> error_;
};

TEST_F(DeviceTest, TelegramsThatComeTogetherAreAllTaken) {
  const auto bytes = telegrams_with_filling({1, 2, 3, 4});
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    const auto all = std::span(bytes);
    given_ = {{.bytes = all.first(cut)}, {.bytes = all.subspan(cut)}};
    taken_.clear();
    ASSERT_TRUE(device()->wait(tims::os::now()));
    taken_.erase(std::unique(taken_.begin(), taken_.end()), taken_.end());
    ASSERT_THAT(taken_, ElementsAre(1, 2, 3, 4)) << "cut at " << cut;
  }
}

TEST_F(DeviceTest, EachSliceHasTheTimeOfItsBytes) {
  const std::vector<std::byte> bytes(40);
  given_ = {{.bytes = bytes, .first = Time{10s}, .last = Time{50s}}};
  ASSERT_TRUE(device()->wait(tims::os::now()));
  std::size_t begin = 0;
  for (const Arrival& piece : dialogue_.pieces) {
    EXPECT_EQ(piece.bytes.data(), bytes.data() + begin) << "none is missing, none comes twice";
    EXPECT_EQ(piece.first, Time{10s} + 1s * begin);
    begin += piece.bytes.size();
    EXPECT_EQ(piece.last, Time{10s} + 1s * begin);
  }
  EXPECT_EQ(begin, bytes.size());
}

TEST_F(DeviceTest, FramesStayWholeAndEachOfThemIsTaken) {
  const auto one = telegrams_with_filling({7, 7, 7});
  const auto other = telegrams_with_filling({8, 8, 8});
  given_ = {{.bytes = one, .id = 4711}, {.bytes = other, .id = 4711}, {.id = 4711}};
  ASSERT_TRUE(device()->wait(tims::os::now()));
  ASSERT_EQ(dialogue_.pieces.size(), 3U);
  EXPECT_EQ(dialogue_.pieces[0].bytes.size(), one.size());
  EXPECT_EQ(dialogue_.pieces[2].bytes.size(), 0U) << "a datagram may be empty";
  EXPECT_THAT(taken_, ElementsAre(7, 8));
}

TEST_F(DeviceTest, WhatWasSentThenIsNoArrival) {
  const auto bytes = telegrams_with_filling({1, 2});
  given_ = {{.bytes = bytes, .is_sent = true}};
  ASSERT_TRUE(device()->wait(tims::os::now()));
  EXPECT_TRUE(dialogue_.pieces.empty());
  EXPECT_TRUE(taken_.empty());
  ASSERT_EQ(dialogue_.sent.size(), 1U);
  EXPECT_EQ(dialogue_.sent[0].bytes.size(), bytes.size());
}

TEST_F(DeviceTest, NothingIsReceivedAfterAFailure) {
  const auto bytes = telegrams_with_filling({1, Numbers::kNonsense, 3});
  given_ = {{.bytes = bytes}, {.bytes = bytes}};
  const auto waited = device()->wait(tims::os::now());
  ASSERT_FALSE(waited);
  EXPECT_EQ(waited.error().detail(), "nonsense");
  EXPECT_EQ(dialogue_.pieces.size(), 2U);
}

TEST_F(DeviceTest, AnErrorOfTakeIsReportedOnce) {
  const auto bytes = telegrams_with_filling({1, 2});
  given_ = {{.bytes = bytes}};
  error_ = {tims::Errc::kInvalidArgument, "too large"};
  const auto asked = device();
  const auto waited = asked->wait(tims::os::now());
  ASSERT_FALSE(waited);
  EXPECT_EQ(waited.error().detail(), "too large");
  EXPECT_THAT(taken_, ElementsAre(1));
  error_.reset();
  EXPECT_TRUE(asked->wait(tims::os::now()));
}

// The killed program may have written an incomplete line.
TEST(StopCommandsTest, AnAdapterReceivesLinesOfText) {
  std::vector<Arrival> none;
  const auto adapter = open_slcan(std::make_unique<Given>(none), 500000);
  ASSERT_TRUE(adapter) << adapter.error().message();
  std::string all;
  for (const auto& piece : (*adapter)->to_write(
           {{.bytes = {std::byte{0xDE}, std::byte{0xAD}}, .id = 0x123}, {.id = 0x80000007}}))
    for (const std::byte byte : piece) all += std::to_integer<char>(byte);
  EXPECT_EQ(all, "\rt1232DEAD\rT000000070\r");
}

}  // namespace device_test
}  // namespace rack::device
