// A USB converter (FT232) with the kernel's driver, as in the virtual machine of `tools/dev
// vm-test`: it is recognised, has a low latency, and unplugging is detected. Skipped without a
// converter.
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include "components/devices/io/host_devices.h"
#include "os/clock.h"
#include "rack/devices/transport.h"
#include "tests/support/eventually.h"

namespace rack::device {
namespace converter_test {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;
using tims::test::eventually;

constexpr std::uint16_t kFtdi = 0x0403;
constexpr std::uint16_t kFt232 = 0x6001;

std::optional<HostDevice> converter() {
  for (const HostDevice& device : host_devices())
    if (device.kind == HostDeviceKind::kSerial && device.usb && device.usb->vendor == kFtdi &&
        device.usb->product == kFt232 && device.usb->text.starts_with("QEMU"))
      return device;
  return std::nullopt;
}

// Position on the USB bus, for example "1-1".
std::string place_of(const HostDevice& device) {
  namespace fs = std::filesystem;
  fs::path path = fs::canonical("/sys/class/tty/" + device.node + "/device");
  while (!fs::exists(path / "idVendor")) path = path.parent_path();
  return path.filename();
}

// Simulates unplugging and plugging in, by unbinding or binding the USB device.
void set_plugged(const std::string& place, bool in) {
  std::ofstream(std::string("/sys/bus/usb/drivers/usb/") + (in ? "bind" : "unbind")) << place;
}

class ConverterTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!converter()) GTEST_SKIP() << "no converter: tools/dev vm-test";
  }
  static std::unique_ptr<Transport> opened() {
    auto transport = open_transport(*DeviceAddress::parse(device_address(*converter())), 500000);
    EXPECT_TRUE(transport) << transport.error().message();
    return transport ? std::move(*transport) : nullptr;
  }
};

TEST_F(ConverterTest, IsRecognised) {
  const HostDevice device = *converter();
  EXPECT_EQ(device.driver, "ftdi_sio");
  EXPECT_EQ(device_text(device), "converter FTDI FT232");
  EXPECT_TRUE(device.latency_ms.has_value());
  EXPECT_TRUE(device.may_use);
}

TEST_F(ConverterTest, ADriverMakesItFastAndIsSeenToUseIt) {
  const auto transport = opened();
  EXPECT_THAT(transport->description(), HasSubstr("500000 baud, low latency"));
  EXPECT_EQ(converter()->latency_ms, 1);
  ASSERT_EQ(converter()->used_by.size(), 1U);
  EXPECT_THAT(converter()->used_by[0], HasSubstr(std::to_string(::getpid())));
}

TEST_F(ConverterTest, UnpluggingIsReportedWithAReasonAndPluggedInItIsThere) {
  const auto transport = opened();
  const auto before = host_devices();
  const std::string place = place_of(*converter());
  set_plugged(place, false);
  const Time out = tims::os::now();
  tims::Result<void> received;
  while (received && tims::os::now() < out + 5s) {
    pollfd wait{.fd = transport->descriptor(), .events = POLLIN, .revents = 0};
    ::poll(&wait, 1, 20);
    received = transport->receive(tims::os::now(), [](const Arrival&) {});
  }
  ASSERT_FALSE(received);
  EXPECT_THAT(received.error().detail(), HasSubstr("gone"));
  const auto changed = changes(before, host_devices());
  EXPECT_TRUE(std::ranges::any_of(
      changed, [](const DeviceChange& change) { return !change.is_there && change.device.usb; }));
  set_plugged(place, true);
  EXPECT_TRUE(eventually([] { return converter() && converter()->may_use; }, "it is there again"));
  EXPECT_TRUE(opened());
}

}  // namespace converter_test
}  // namespace rack::device
