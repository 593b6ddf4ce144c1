#include "components/devices/pins/firmata.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/pins/io_board.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace firmata_test {

using namespace std::chrono_literals;
using emulator::LineSettings;
using emulator::VirtualLine;

constexpr LineSettings kSerial{
    .has_rate = true, .host_baud = 57600, .device_baud = 57600, .piece = 5};

IoSettings board() {
  return {.layout = {.inputs = {2, 3}, .outputs = {13, 12, 11}, .analogs = {0}}, .period = 100ms};
}

std::vector<std::byte> bytes(std::initializer_list<unsigned> values) {
  std::vector<std::byte> all;
  firmata::append(all, values);
  return all;
}

std::vector<int> values_of(const IoData& data) { return {data.values.begin(), data.values.end()}; }

TEST(FirmataTest, EverySplitGivesTheSameMessages) {
  // Noise, a level, a half message, the firmware's name, an analog value.
  const auto stream = bytes({0x12, 0x90, 0x04, 0x00, 0xE1, 0x05, 0xF0, 0x79, 2, 6, 'A', 0, 0xF7,
                             0xE0, 0x7F, 0x07, 0xF9, 2, 6});
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    FirmataMessages messages;
    std::vector<std::size_t> sizes;
    for (const auto piece : {std::span(stream).first(cut), std::span(stream).subspan(cut)}) {
      messages.add({.bytes = piece});
      while (const auto message = messages.next()) sizes.push_back(message->size());
    }
    EXPECT_EQ(sizes, (std::vector<std::size_t>{3, 7, 3, 3})) << cut;
  }
}

// The messages of the protocol's description.
TEST(FirmataTest, TheFirstMessagesToABoard) {
  Firmata driver(board());
  struct Keeper : Output {
    std::vector<std::vector<std::byte>> sent;
    void send(std::span<const std::byte> message, std::uint32_t) override {
      sent.emplace_back(message.begin(), message.end());
    }
  } keeper;
  driver.start(Time(1s), keeper);
  ASSERT_EQ(keeper.sent.size(), 1U);
  EXPECT_EQ(keeper.sent[0], bytes({0xF0, 0x79, 0xF7}));
  const auto answer = bytes({0xF0, 0x79, 2, 5, 'U', 0, 'N', 0, 0xF7});
  driver.on_arrival({.bytes = answer, .last = Time(2s)}, keeper);
  EXPECT_TRUE(driver.is_ready());
  EXPECT_EQ(driver.firmware(), "UN 2.5");
  ASSERT_EQ(keeper.sent.size(), 2U);
  EXPECT_EQ(keeper.sent[1],
            bytes({0xF4, 2,  0, 0xD0, 1,  0xF4, 3,    0, 0xD0, 1,    0xF4, 13, 1,
                   0xF4, 12, 1, 0xF4, 11, 1,    0xC0, 1, 0xF0, 0x7A, 100,  0,  0xF7}));
}

TEST(FirmataTest, OutputsAreSetAndInputsSeen) {
  emulator::IoBoard uno;
  Firmata driver(board());
  VirtualLine line(driver, uno, kSerial);
  line.start();
  IoData data;
  Time recorded;
  ASSERT_TRUE(line.run(5s, [&] { return driver.take(data, recorded); }));
  EXPECT_EQ(data.values.size(), 6U);
  constexpr std::array<u8, 3> kOn = {1, 0, 1};
  driver.set(kOn);
  ASSERT_TRUE(line.run(1s, [&] {
    return driver.take(data, recorded) && data.values[0] == 1;  // pin 13 is wired to pin 2
  }));
  EXPECT_TRUE(uno.level(13));
  EXPECT_FALSE(uno.level(12));
  const auto values = values_of(data);
  EXPECT_EQ(std::vector(values.begin(), values.begin() + 5), (std::vector{1, 0, 1, 0, 1}));
  constexpr std::array<u8, 3> kOther = {0, 1, 0};
  driver.set(kOther);
  ASSERT_TRUE(line.run(1s, [&] { return driver.take(data, recorded) && data.values[1] == 1; }));
  EXPECT_EQ(data.values[0], 0);
  // Unchanged values are published periodically.
  const Time before = recorded;
  ASSERT_TRUE(line.run(1s, [&] { return driver.take(data, recorded); }));
  EXPECT_LE(recorded - before, 150ms);
}

TEST(FirmataTest, ABoardThatWasResetIsSetUpAgain) {
  emulator::IoBoard uno;
  Firmata driver(board());
  VirtualLine line(driver, uno, kSerial);
  line.start();
  IoData data;
  Time recorded;
  ASSERT_TRUE(line.run(5s, [&] { return driver.take(data, recorded); }));
  // A board sends its firmware when it starts.
  struct Nobody : Output {
    void send(std::span<const std::byte>, std::uint32_t) override {}
  } nobody;
  uno.start(line.now(), nobody);
  line.disturb(bytes({0xF9, 2, 6, 0xF0, 0x79, 2, 6, 'A', 0, 0xF7}));
  line.run(200ms);
  uno.set_level(3, true);
  EXPECT_TRUE(line.run(1s, [&] { return driver.take(data, recorded) && data.values[1] == 1; }));
}

TEST(FirmataTest, AMissingAnswerAndSilenceAreReported) {
  emulator::IoBoard uno;
  Firmata driver(board());
  VirtualLine line(driver, uno, kSerial);
  bool is_dead = true;
  line.set_lose([&](bool, std::span<const std::byte>) { return is_dead; });
  line.start();
  ASSERT_TRUE(line.run(10s, [&] { return driver.failure().has_value(); }));
  EXPECT_THAT(driver.failure()->detail(), testing::HasSubstr("Firmata"));
  is_dead = false;
  line.start_host();
  ASSERT_TRUE(line.run(5s, [&] { return driver.is_ready(); }));
  is_dead = true;
  ASSERT_TRUE(line.run(5s, [&] { return driver.failure().has_value(); }));
  EXPECT_THAT(driver.failure()->detail(), testing::HasSubstr("stopped sending"));
}

TEST(FirmataTest, NoiseBreaksNothing) {
  std::mt19937 random(1);
  emulator::IoBoard uno;
  Firmata driver(board());
  VirtualLine line(driver, uno, kSerial);
  line.start();
  for (int i = 0; i < 500; ++i) {
    std::vector<std::byte> noise(random() % 80);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random() % 256);
    line.disturb(noise);
    line.run(30ms);
    if (driver.failure()) line.start_host();
  }
  IoData data;
  Time recorded;
  driver.take(data, recorded);
  EXPECT_TRUE(line.run(5s, [&] { return driver.take(data, recorded); }));
}

TEST(GpioPinsTest, LevelsComeAndOutputsGo) {
  GpioPins driver({.layout = {.inputs = {17, 27}, .outputs = {300}}});
  struct Keeper : Output {
    std::vector<std::pair<std::uint32_t, int>> sent;
    void send(std::span<const std::byte> level, std::uint32_t id) override {
      sent.emplace_back(id, std::to_integer<int>(level[0]));
    }
  } keeper;
  driver.start(Time(1s), keeper);
  const std::array high = {std::byte{1}};
  driver.on_arrival({.bytes = high, .last = Time(2s), .id = 27}, keeper);
  IoData data;
  Time recorded;
  ASSERT_TRUE(driver.take(data, recorded));
  EXPECT_EQ(values_of(data), (std::vector{0, 1, 0}));
  EXPECT_EQ(recorded, Time(2s));
  driver.on_arrival({.bytes = high, .last = Time(2s), .id = 99}, keeper);
  EXPECT_FALSE(driver.take(data, recorded));
  constexpr std::array<u8, 1> kOn = {1};
  driver.set(kOn);
  EXPECT_LE(driver.next_timeout(), Time(2s));
  driver.on_timeout(Time(2s), keeper);
  EXPECT_EQ(keeper.sent, (std::vector<std::pair<std::uint32_t, int>>{{300, 1}}));
  ASSERT_TRUE(driver.take(data, recorded));
  EXPECT_EQ(values_of(data), (std::vector{0, 1, 1}));
  // Repeated each period.
  EXPECT_GT(driver.next_timeout(), Time(2s));
  driver.on_timeout(driver.next_timeout(), keeper);
  EXPECT_TRUE(driver.take(data, recorded));
}

}  // namespace firmata_test
}  // namespace rack::device
