// Drivers of SICK scanners as real programs: emulated scanners at terminals and sockets are
// unplugged, plugged in again, and replaced. Recordings of real ones: captures_test.cpp.
#include <thread>

#include <arpa/inet.h>
#include <sys/socket.h>

#include "components/devices/scanners/room.h"
#include "components/devices/scanners/sick_compact_emulator.h"
#include "os/clock.h"
#include "os/file.h"
#include "rack/proxies/ladar.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/becomes.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace sick_drivers_test {

namespace device = rack::device;
using rack::LadarProxy;

constexpr std::uint32_t kLadar = 0x00140000;

class SickDriversTest : public ModulesTest {
 protected:
  LadarProxy ladar() { return proxy<LadarProxy>(kLadar); }
  testing::AssertionResult becomes(rack::Status wanted) {
    return tims::test::becomes(*work_, "Ladar(0/0)", wanted);
  }

  // Checks that the scans show the emulated room.
  void expect_room(double exactness) {
    const auto scan = ladar().get_data();
    ASSERT_TRUE(scan) << scan.error().message();
    const device::emulator::Room room;
    for (const rack::LadarPoint& point : scan->points)
      ASSERT_NEAR(point.distance, room.distance(static_cast<double>(point.angle)), exactness);
  }

  // The driver is turned on, the scanner unplugged and plugged in again.
  void expect_to_come_back(const std::string& name, const std::string& address, double exactness) {
    auto emulator = emulate(name, address);
    ASSERT_TRUE(ladar().on());
    expect_room(exactness);
    ASSERT_TRUE(emulator.stop(SIGKILL));
    EXPECT_TRUE(becomes(rack::Status::kError));
    emulator = emulate(name, address);
    EXPECT_TRUE(eventually([&] { return ladar().get_data().ok(); }, "scans again", 3s));
    expect_room(exactness);
  }

  TemporaryFolder folder_;
};

TEST_F(SickDriversTest, Lms200AtATerminal) {
  const std::string path = folder_.path() / "lms";
  start("LadarSickLms200", {"--device=serial:" + path, "--baudrate=500000", "--protocol=2"});
  expect_to_come_back("lms200", "pty:" + path, 1);
}

TEST_F(SickDriversTest, ColaAtAPort) {
  const std::string port = free_port(SOCK_STREAM);
  start("LadarSickCola", {"--device=tcp:127.0.0.1:" + port});
  expect_to_come_back("sick-cola", "tcp:127.0.0.1:" + port, 1);
}

TEST_F(SickDriversTest, Lms100) {
  const std::string port = free_port(SOCK_STREAM);
  start("LadarSickLms100", {"--lmsIp=127.0.0.1", "--lmsPort=" + port});
  auto emulator = emulate("sick-cola-a", "tcp:127.0.0.1:" + port);
  ASSERT_TRUE(ladar().on());
  expect_room(1);
}

TEST_F(SickDriversTest, SafetyScannerAtATerminal) {
  const std::string path = folder_.path() / "s3000";
  start("LadarSickS", {"--device=serial:" + path, "--devNumber=3000"});
  expect_to_come_back("sick-s3000", "pty:" + path, 6);
}

// Sends to a port of this host.
class Sender : public device::Output {
 public:
  explicit Sender(const std::string& port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to_.sin_port = htons(static_cast<std::uint16_t>(std::stoul(port)));
  }
  void send(std::span<const std::byte> bytes, std::uint32_t) override {
    (void)::sendto(socket_.get(), bytes.data(), bytes.size(), 0,
                   reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
  }

 private:
  os::File socket_;
  sockaddr_in to_{};
};

// A scanner that sends until it is destroyed.
std::jthread pico_scan(const std::string& port, std::uint32_t serial_number) {
  return std::jthread([port, serial_number](const std::stop_token& stop) {
    Sender sender(port);
    device::emulator::SickCompactEmulator emulator({.serial_number = serial_number});
    emulator.start(os::now(), sender);
    for (; !stop.stop_requested(); std::this_thread::sleep_for(2ms))
      if (emulator.next_timeout() <= os::now()) emulator.on_timeout(os::now(), sender);
  });
}

TEST_F(SickDriversTest, PicoScan) {
  const std::string port = free_port(SOCK_STREAM);
  start("LadarSickPicoScan", {"--device=udp::" + port});
  auto scanner = pico_scan(port, 1);
  ASSERT_TRUE(ladar().on());
  expect_room(4);
  scanner = {};
  EXPECT_TRUE(becomes(rack::Status::kError));
}

// The new scanner is used, and each change is reported once.
TEST_F(SickDriversTest, AReplacedScannerIsReported) {
  const std::string port = free_port(SOCK_STREAM);
  auto& program = start("LadarSickPicoScan", {"--device=udp::" + port});
  auto scanner = pico_scan(port, 101);
  ASSERT_TRUE(ladar().on());
  for (const std::uint32_t serial_number : {101U, 102U, 102U, 101U}) {
    scanner = {};
    EXPECT_TRUE(becomes(rack::Status::kError));
    scanner = pico_scan(port, serial_number);
    EXPECT_TRUE(becomes(rack::Status::kEnabled)) << program.output();
  }
  const auto line = program.wait_for_line("is a different device: serial number 101, before 102");
  ASSERT_TRUE(line) << line.error().message();
  const std::string all = program.output();
  const std::string once = "is a different device: serial number 102, before 101";
  EXPECT_NE(all.find(once), std::string::npos) << all;
  EXPECT_EQ(all.find(once), all.rfind(once)) << all;
}

// In every driver whose device reports its serial number.
TEST_F(SickDriversTest, AnUnexpectedScannerIsRefused) {
  const std::string path = folder_.path() / "scanner";
  const auto expect_refused = [&](const std::string& name, const std::string& program,
                                  const std::string& sentence) {
    const auto emulator = emulate(name, "pty:" + path);
    auto& driver = start(program, {"--device=serial:" + path, "--serialNumber=1234"});
    EXPECT_FALSE(ladar().on());
    const auto line = driver.wait_for_line(sentence);
    EXPECT_TRUE(line) << line.error().message();
    kill(program);
  };
  expect_refused("hokuyo", "LadarHokuyoUrg", "serial number H0614967; required: 1234");
  expect_refused("rplidar", "LadarRplidar", "serial number c0de0102030405");
}

TEST_F(SickDriversTest, ReportWhatIsMissing) {
  auto& program = start("LadarSickLms100");
  EXPECT_FALSE(ladar().on());
  const auto line = program.wait_for_line("lmsIp is missing");
  EXPECT_TRUE(line) << line.error().message();
}

}  // namespace sick_drivers_test
}  // namespace tims::test
