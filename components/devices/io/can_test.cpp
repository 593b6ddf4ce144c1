// SocketCAN with the kernel's virtual interface, two transports on one bus. Skipped if the kernel
// has no vcan: `tools/dev vm-test` runs a kernel that has it.
#include <array>
#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "components/devices/io/host_devices.h"
#include "components/devices/io/transports.h"
#include "os/clock.h"
#include "os/file.h"
#include "rack/devices/device.h"
#include "tests/support/child_process.h"

namespace rack::device {
namespace can_test {

using namespace std::chrono_literals;
using testing::ElementsAre;
using tims::os::File;

constexpr const char* kInterface = "rackvcan0";

bool run(std::vector<std::string> command) {
  auto child = tims::test::ChildProcess::start(std::move(command));
  const auto status = child ? child->wait() : tims::Result<tims::test::ExitStatus>(child.error());
  return status && status->success();
}

struct Frame {
  std::uint32_t id;
  std::string bytes;
  Time when;

  bool operator==(const Frame& other) const { return id == other.id && bytes == other.bytes; }
};

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

class CanTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!run({"ip", "link", "add", kInterface, "type", "vcan"}))
      GTEST_SKIP() << "no vcan: tools/dev vm-test";
    ASSERT_TRUE(run({"ip", "link", "set", kInterface, "up"}));
  }
  void TearDown() override { run({"ip", "link", "del", kInterface}); }

  static std::unique_ptr<Transport> opened(const std::vector<CanFilter>& filters = {CanFilter{}}) {
    auto transport = open_can({.kind = TransportKind::kCan, .place = kInterface}, filters);
    EXPECT_TRUE(transport) << transport.error().message();
    return transport ? std::move(*transport) : nullptr;
  }
  static void send(Transport& transport, std::uint32_t id, std::string_view text) {
    const auto sent = transport.send(tims::os::now(), bytes_of(text), id);
    ASSERT_TRUE(sent) << sent.error().message();
    EXPECT_TRUE(*sent);
  }
  // Receives `count` frames; with count 0, the frames received within a short time.
  static std::vector<Frame> receive(Transport& transport, std::size_t count) {
    std::vector<Frame> all;
    const Time end = tims::os::now() + (count == 0 ? Duration(100ms) : Duration(5s));
    while ((count == 0 || all.size() < count) && tims::os::now() < end) {
      pollfd wait{.fd = transport.descriptor(), .events = POLLIN, .revents = 0};
      ::poll(&wait, 1, 20);
      const auto received = transport.receive(tims::os::now(), [&](const Arrival& arrival) {
        std::string text;
        for (const std::byte byte : arrival.bytes) text += static_cast<char>(byte);
        all.push_back({arrival.id, text, arrival.last});
      });
      EXPECT_TRUE(received) << received.error().message();
      if (!received) break;
    }
    return all;
  }
};

TEST_F(CanTest, FramesArriveWholeInOrderWithTimesThatWere) {
  const auto one = opened();
  const auto other = opened();
  const Time before = tims::os::now();
  send(*one, 0x181, "12345678");
  send(*one, 0x80000000U | 0x18DAF110, "");
  send(*one, 0x7FF, "x");
  const auto received = receive(*other, 3);
  EXPECT_THAT(received, ElementsAre(Frame{0x181, "12345678", {}}, Frame{0x98DAF110, "", {}},
                                    Frame{0x7FF, "x", {}}));
  for (const Frame& one_of_them : received) {
    EXPECT_GE(one_of_them.when, before - 50ms);
    EXPECT_LE(one_of_them.when, tims::os::now());
  }
  EXPECT_TRUE(receive(*one, 0).empty()) << "its own frames";
}

TEST_F(CanTest, TheKernelFilters) {
  const auto sender = opened();
  const auto filtered =
      opened({{.id = 0x580, .mask = 0x780}, {.id = 0x80000100, .mask = 0x9FFFFFFF}});
  for (const std::uint32_t id : {0x181U, 0x581U, 0x100U, 0x5FFU, 0x600U, 0x80000100U})
    send(*sender, id, "x");
  EXPECT_THAT(receive(*filtered, 3), ElementsAre(Frame{0x581, "x", {}}, Frame{0x5FF, "x", {}},
                                                 Frame{0x80000100, "x", {}}));
  EXPECT_TRUE(receive(*filtered, 0).empty());
}

struct Picky final : Dialogue {
  void start(Time, Output&) override {}
  void on_arrival(const Arrival& arrival, Output&) override { ids.push_back(arrival.id); }
  [[nodiscard]] std::vector<CanFilter> wanted_frames() const override {
    return {{.id = 0x585, .mask = 0x7FF}};
  }
  std::vector<std::uint32_t> ids;
};

TEST_F(CanTest, ADialogueReceivesTheFramesOfItsFilter) {
  const auto sender = opened();
  Picky dialogue;
  const auto device =
      Device::open({.address = {.kind = TransportKind::kCan, .place = kInterface}}, dialogue);
  ASSERT_TRUE(device) << device.error().message();
  for (const std::uint32_t id : {0x585U, 0x586U, 0x181U, 0x585U}) send(*sender, id, "x");
  const Time end = tims::os::now() + 5s;
  while (dialogue.ids.size() < 2 && tims::os::now() < end) ASSERT_TRUE((*device)->wait(end));
  EXPECT_THAT(dialogue.ids, ElementsAre(0x585, 0x585));
}

TEST_F(CanTest, WithoutFiltersNothingIsReceived) {
  const auto sender = opened();
  const auto silent = opened({});
  send(*sender, 0x181, "x");
  EXPECT_TRUE(receive(*silent, 0).empty());
}

// Error frames normally come from the controller; here another socket sends one.
TEST_F(CanTest, ErrorFramesArriveWithTheirFlag) {
  const auto listener = opened();
  const File socket(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  sockaddr_can where{};
  where.can_family = AF_CAN;
  where.can_ifindex = static_cast<int>(::if_nametoindex(kInterface));
  ASSERT_EQ(::bind(socket.get(), reinterpret_cast<sockaddr*>(&where), sizeof where), 0);
  can_frame frame{};
  frame.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF;
  frame.can_dlc = CAN_ERR_DLC;
  ASSERT_EQ(::write(socket.get(), &frame, sizeof frame), static_cast<ssize_t>(sizeof frame));
  const auto received = receive(*listener, 1);
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(received[0].id, CAN_ERR_FLAG | CAN_ERR_BUSOFF);
}

TEST_F(CanTest, AFrameHasEightBytesAtMost) {
  const auto transport = opened();
  const auto sent = transport->send(tims::os::now(), bytes_of("123456789"), 1);
  ASSERT_TRUE(sent);
  EXPECT_FALSE(*sent);
}

// A thousand frames at once, more than any queue holds: frames may be lost, but not reordered.
TEST_F(CanTest, AFloodIsTakenInOrder) {
  const auto sender = opened();
  const auto receiver = opened();
  std::vector<Frame> all;
  for (int i = 0; i < 1000; ++i) {
    send(*sender, 0x100, std::to_string(i));
    if (i % 50 == 49)
      for (const Frame& frame : receive(*receiver, 50)) all.push_back(frame);
  }
  ASSERT_EQ(all.size(), 1000U);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].bytes, std::to_string(i));
}

TEST_F(CanTest, ARemovedInterfaceIsReportedWithAReason) {
  const auto transport = opened();
  ASSERT_TRUE(run({"ip", "link", "del", kInterface}));
  const Time end = tims::os::now() + 5s;
  tims::Result<void> received;
  while (received && tims::os::now() < end) {
    pollfd wait{.fd = transport->descriptor(), .events = POLLIN, .revents = 0};
    ::poll(&wait, 1, 20);
    received = transport->receive(tims::os::now(), [](const Arrival&) {});
  }
  ASSERT_FALSE(received);
  EXPECT_THAT(received.error().detail(), testing::HasSubstr("gone"));
}

// The dialogue of a vehicle without a watchdog.
class Driving final : public Dialogue {
 public:
  void start(Time, Output& out) override { out.send(bytes_of("go"), 0x21); }
  void on_arrival(const Arrival&, Output&) override {}
  [[nodiscard]] std::vector<Telegram> stop_commands() const override {
    return {{.bytes = bytes_of("stand"), .id = 0x22}, {.bytes = {}, .id = 0x80000123}};
  }
};

TEST_F(CanTest, TheGuardSendsWhenItsDriverIsKilled) {
  const auto other = opened();
  const pid_t driver = ::fork();
  if (driver == 0) {
    Driving dialogue;
    const DeviceOptions options{.address = {.kind = TransportKind::kCan, .place = kInterface}};
    const auto device = Device::open(options, dialogue);
    if (!device) ::_exit(1);
    for (;;) ::pause();
  }
  ASSERT_GT(driver, 0);
  EXPECT_THAT(receive(*other, 1), ElementsAre(Frame{0x21, "go", {}}));
  EXPECT_TRUE(receive(*other, 0).empty());
  ::kill(driver, SIGKILL);
  ::waitpid(driver, nullptr, 0);
  EXPECT_THAT(receive(*other, 2), ElementsAre(Frame{0x22, "stand", {}}, Frame{0x80000123, "", {}}));
}

TEST_F(CanTest, AnInterfaceThatIsDownIsReported) {
  ASSERT_TRUE(run({"ip", "link", "set", kInterface, "down"}));
  const auto transport = open_can({.kind = TransportKind::kCan, .place = kInterface}, {});
  const bool failed = !transport ||
                      !(*transport)->receive(tims::os::now(), [](const Arrival&) {}) ||
                      !(*transport)->send(tims::os::now(), bytes_of("x"), 1);
  EXPECT_TRUE(failed) << "a driver would wait forever";
}

TEST_F(CanTest, TheListOfDevicesShowsIt) {
  const auto devices = host_devices();
  const auto found = std::ranges::find(devices, kInterface, &HostDevice::node);
  ASSERT_NE(found, devices.end());
  EXPECT_EQ(found->kind, HostDeviceKind::kCan);
  EXPECT_TRUE(found->is_up);
  EXPECT_EQ(device_address(*found), "can:" + std::string(kInterface));
}

TEST(CanWithoutTest, AMissingInterfaceIsNamed) {
  const auto transport = open_can({.kind = TransportKind::kCan, .place = "nocan7"}, {});
  ASSERT_FALSE(transport);
  EXPECT_THAT(transport.error().detail(),
              testing::AnyOf(testing::HasSubstr("nocan7"), testing::HasSubstr("modprobe")));
}

}  // namespace can_test
}  // namespace rack::device
