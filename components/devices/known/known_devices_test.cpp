#include "components/devices/known/known_devices.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace known_devices_test {

TEST(KnownDevicesTest, EachIsFoundAndTheyAreInOrder) {
  std::uint32_t before = 0;
  for (const KnownUsb& known : known_usb()) {
    const std::uint32_t key = std::uint32_t{known.vendor} << 16 | known.product;
    EXPECT_GT(key, before) << known.device;
    before = key;
    EXPECT_EQ(find_usb(known.vendor, known.product), &known);
  }
}

TEST(KnownDevicesTest, WhatIsNotInTheListIsNotKnown) {
  EXPECT_EQ(find_usb(0, 0), nullptr);
  EXPECT_EQ(find_usb(0x15D1, 1), nullptr);
  EXPECT_EQ(find_usb(0xFFFF, 0xFFFF), nullptr);
}

// Names are part of file names; devices used through libusb need no module.
TEST(KnownDevicesTest, RowsAreWhole) {
  for (const KnownUsb& known : known_usb()) {
    EXPECT_FALSE(known.device.empty());
    EXPECT_EQ(known.name.empty(), known.use == UsbUse::kCan) << known.device;
    EXPECT_EQ(known.module.empty(), known.use == UsbUse::kRaw) << known.device;
    for (const char c : known.name)
      EXPECT_TRUE((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) << known.name;
  }
}

}  // namespace known_devices_test
}  // namespace rack::device
