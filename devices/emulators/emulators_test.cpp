#include "devices/emulators/emulators.h"

#include <set>

#include <gtest/gtest.h>

#include "devices/core/device_address.h"

namespace rack::device {
namespace {

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
      const auto emulator = info.make();
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

}  // namespace
}  // namespace rack::device
