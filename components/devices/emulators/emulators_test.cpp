#include "components/devices/emulators/emulators.h"

#include <array>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "rack/devices/device_address.h"

namespace rack::device {
namespace emulators_test {

class Nobody final : public Output {
 public:
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

TEST(EmulatorsTest, EachIsFoundByItsNameAndStartsTwice) {
  std::set<std::string_view> names;
  for (const EmulatorInfo& info : emulators()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name << " twice";
    EXPECT_EQ(find_emulator(info.name), &info);
    EXPECT_FALSE(info.device.empty()) << info.name;
    Nobody out;
    for (int i = 0; i < 2; ++i) {
      const auto emulator = info.make({});
      ASSERT_TRUE(emulator) << info.name;
      emulator->start(Time{std::chrono::seconds(1000)}, out);
      EXPECT_FALSE(emulator->failure()) << info.name;
    }
  }
}

TEST(EmulatorsTest, EachHasAnAddressWhereADriverFindsIt) {
  for (const EmulatorInfo& info : emulators()) {
    const auto address = DeviceAddress::parse(info.address);
    EXPECT_TRUE(address) << info.name << ": " << address.error().message();
  }
}

TEST(EmulatorsTest, WhatIsNotThereIsNone) { EXPECT_EQ(find_emulator("teapot"), nullptr); }

class Sent final : public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    bytes_.assign(bytes.begin(), bytes.end());
    id_ = id;
  }

  std::vector<std::byte> bytes_;
  std::uint32_t id_ = 0;
};

TEST(EchoTest, SendsWhatItReceivesWithItsIdentifier) {
  const auto echo = find_emulator("echo")->make({});
  Sent out;
  echo->start(Time{}, out);
  EXPECT_TRUE(out.bytes_.empty());
  const std::array received = {std::byte{1}, std::byte{0}, std::byte{0xFF}};
  echo->on_arrival({.bytes = received, .id = 0x181}, out);
  EXPECT_EQ(out.bytes_, std::vector<std::byte>(received.begin(), received.end()));
  EXPECT_EQ(out.id_, 0x181U);
  EXPECT_EQ(echo->next_timeout(), tims::kNever);
}

}  // namespace emulators_test
}  // namespace rack::device
