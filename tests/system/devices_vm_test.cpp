// Programs with devices of a real kernel. Skipped without such devices; run by `tools/dev vm-test`.
#include <atomic>
#include <bit>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <poll.h>

#include "components/devices/chassis/odrive.h"
#include "os/clock.h"
#include "rack/devices/capture.h"
#include "rack/devices/stream_buffer.h"
#include "rack/devices/transport.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/joystick.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/uinput_stick.h"
#include "tests/system/camera_fixture.h"

namespace tims::test {
namespace devices_vm_test {

namespace device = rack::device;

constexpr std::uint32_t kJoystick = 0x00170000;
constexpr std::uint32_t kChassis = 0x00110000;

class StickProgramTest : public ModulesTest {
 protected:
  void SetUp() override {
    if (!stick_->is_plugged_in()) GTEST_SKIP() << "no uinput: tools/dev vm-test";
    ModulesTest::SetUp();
    ASSERT_TRUE(eventually([] { return std::filesystem::exists("/dev/input/js0"); }, "the stick"));
  }
  rack::JoystickProxy joystick() { return {*work_, Address(kJoystick)}; }
  bool has(auto condition, const char* what) {
    return eventually(
        [&] {
          const auto data = joystick().get_data();
          return data && condition(*data);
        },
        what);
  }

  std::optional<UinputStick> stick_{std::in_place, "RACK program's stick"};
};

TEST_F(StickProgramTest, MovesAndButtonsArrive) {
  start("Joystick", {"--periodTime=20", "--deadZone=0"});
  const auto on = joystick().on();
  ASSERT_TRUE(on) << on.error().message();
  ASSERT_TRUE(stick_->move(ABS_X, UinputStick::kEnd));
  EXPECT_TRUE(has([](const auto& data) { return data.position.y.raw() > 90; }, "to the right"));
  ASSERT_TRUE(stick_->press(true));
  EXPECT_TRUE(has([](const auto& data) { return data.buttons != 0; }, "the button"));
  ASSERT_TRUE(stick_->press(false));
  EXPECT_TRUE(has([](const auto& data) { return data.buttons == 0; }, "no button"));
}

TEST_F(StickProgramTest, AnUnpluggedStickIsReported) {
  auto& program = start("Joystick", {"--periodTime=20"});
  ASSERT_TRUE(joystick().on());
  stick_->pull_out();
  EXPECT_TRUE(program.wait_for_line("error:"));
  stick_.emplace("RACK program's stick");
  EXPECT_TRUE(eventually([&] { return joystick().on().ok(); }, "plugged in again"));
}

TEST_F(StickProgramTest, TimsctlReportsSticks) {
  auto watch = ChildProcess::start(
      {std::string(TIMS_PROGRAMS) + "/timsctl", "device", "watch", "-j", "-n", "2"}, at_router());
  ASSERT_TRUE(watch);
  ASSERT_TRUE(watch->wait_for_line("waiting for changes"));
  {
    const UinputStick second("RACK second stick");
    const auto plugged = watch->wait_for_line("\"plugged\"");
    ASSERT_TRUE(plugged) << plugged.error().message();
    EXPECT_NE(plugged->find("RACK second stick"), std::string::npos) << *plugged;
    EXPECT_NE(plugged->find("Joystick"), std::string::npos) << *plugged;
  }
  EXPECT_TRUE(watch->wait_for_line("\"unplugged\""));
  const auto status = watch->wait();
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_EQ(status->code, 0);
}

// --- CAN

class BusProgramTest : public ModulesTest {
 protected:
  static constexpr const char* kInterface = "racksysvcan0";

  void SetUp() override {
    if (!run({"ip", "link", "add", kInterface, "type", "vcan"}))
      GTEST_SKIP() << "no vcan: tools/dev vm-test";
    ModulesTest::SetUp();
    ASSERT_TRUE(run({"ip", "link", "set", kInterface, "up"}));
  }
  void TearDown() override { run({"ip", "link", "del", kInterface}); }

  static bool run(std::vector<std::string> command) {
    auto child = ChildProcess::start(std::move(command));
    const auto status = child ? child->wait() : Result<ExitStatus>(child.error());
    return status && status->success();
  }
  ChildProcess timsctl(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {std::string(TIMS_PROGRAMS) + "/timsctl", "device"});
    auto child = ChildProcess::start(std::move(arguments), at_router());
    EXPECT_TRUE(child) << child.error().message();
    return std::move(*child);
  }
  // Identifiers and bytes of all frames, in order.
  static std::vector<std::string> frames_of(const std::string& path) {
    std::vector<std::string> frames;
    std::ifstream file(path);
    rack::device::CaptureRecord record;
    for (std::string line; std::getline(file, line);) {
      const auto is_record = rack::device::parse_record(line, record);
      EXPECT_TRUE(is_record) << line;
      if (!is_record || !*is_record) continue;
      std::string frame = std::to_string(record.id) + ":";
      for (const std::byte byte : record.bytes)
        frame += " " + std::to_string(std::to_integer<int>(byte));
      frames.push_back(frame);
    }
    return frames;
  }

  TemporaryFolder folder_;
};

// A candump log of one bus is played at another: the same frames, and no others.
TEST_F(BusProgramTest, ACandumpIsPlayedAtABus) {
  const std::string log = folder_.path() / "car.candump";
  const std::string again = folder_.path() / "again.cap";
  constexpr int kFrames = 300;
  {
    std::ofstream file(log);
    constexpr std::array<const char*, 3> kIds = {"0B4", "025", "18FEF100"};
    for (int i = 0; i < kFrames; ++i)
      file << "(1700000000." << 100000 + i * 1000 << ") can0 "
           << kIds.at(static_cast<std::size_t>(i % 3)) << "#00" << 1000 + i
           << (i % 2 == 0 ? "A5" : "") << '\n';
  }
  const std::string bus = std::string("can:") + kInterface;
  auto recorder = timsctl({"record", bus, again, "-n", std::to_string(kFrames)});
  ASSERT_TRUE(recorder.wait_for_line("; stop with Ctrl-C"));
  auto player = timsctl({"play", log, bus});
  for (ChildProcess* const child : {&player, &recorder}) {
    const auto status = child->wait();
    ASSERT_TRUE(status) << status.error().message();
    EXPECT_TRUE(status->success()) << child->output();
  }
  EXPECT_EQ(frames_of(log).size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(frames_of(again), frames_of(log));
}

// --- the kernel's emulated camera (modprobe vivid)

class VividProgramTest : public CameraTest {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kDriver + "/vivid.0"))
      GTEST_SKIP() << "no camera vivid: tools/dev vm-test";
    if (RACK_WITH_OPENCV == 0) GTEST_SKIP() << "built without pictures";
    CameraTest::SetUp();
  }
  void TearDown() override {
    if (!std::filesystem::exists(kDriver + "/vivid.0")) plug("bind");
  }
  static void plug(const std::string& how) { std::ofstream(kDriver + "/" + how) << "vivid.0"; }

  static inline const std::string kDriver = "/sys/bus/platform/drivers/vivid";
};

TEST_F(VividProgramTest, PicturesHaveTheFormatThatIsSet) {
  start("CameraV4l", {"--width=640", "--height=480", "--fps=30", "--mode=rgb24"});
  const auto on = camera().on();
  ASSERT_TRUE(on) << on.error().message();
  const rack::CameraData first = next_picture();
  EXPECT_EQ(first.mode, rack::camera_mode::kRgb24);
  EXPECT_GE(first.width.raw(), 320);
  EXPECT_TRUE(
      eventually([&] { return next_picture().image != first.image; }, "the pictures change"));
  // As the selection box of the original's GUI does.
  for (const auto& [mode, depth] : {std::pair{rack::camera_mode::kMono8, 8},
                                    {rack::camera_mode::kYuv422, 16},
                                    {rack::camera_mode::kJpeg, -1}}) {
    const auto set = camera().set_format({.width = -1, .height = -1, .depth = depth, .mode = mode});
    ASSERT_TRUE(set) << set.error().message();
    EXPECT_TRUE(eventually([&] { return next_picture().mode == mode; }, std::to_string(mode)));
  }
  // It is neither a depth nor a stereo camera: refused at once, and the old format is kept.
  const auto range = camera().set_format(
      {.width = -1, .height = -1, .depth = -1, .mode = rack::camera_mode::kRange});
  EXPECT_FALSE(range);
  EXPECT_EQ(next_picture().mode, rack::camera_mode::kJpeg);
}

TEST_F(VividProgramTest, ASecondProgramIsRefused) {
  start("CameraV4l", {"--width=640", "--height=480"});
  ASSERT_TRUE(camera().on());
  start("CameraV4l", {"--instance=1", "--width=320", "--height=180"});
  const auto on = camera(kSecondCamera).on();
  ASSERT_FALSE(on);
  EXPECT_THAT(on.error().message(), testing::HasSubstr("used by another program"));
}

TEST_F(VividProgramTest, UnpluggingIsReportedAndItContinuesWhenPluggedIn) {
  start("CameraV4l", {"--width=640", "--height=480", "--fps=30"});
  ASSERT_TRUE(camera().on());
  for (int i = 0; i < 2; ++i) {
    next_picture();
    plug("unbind");
    EXPECT_TRUE(eventually([&] { return has_status(rack::Status::kError); }, "an error"));
    plug("bind");
    EXPECT_TRUE(eventually([&] { return camera().get_next_data(1s).ok(); }, "pictures again"));
  }
}

// --- a vehicle at a CAN bus

constexpr const char* kBus = "rackvcan1";

bool run(std::vector<std::string> command) {
  auto child = ChildProcess::start(std::move(command));
  const auto status = child ? child->wait() : Result<ExitStatus>(child.error());
  return status && status->success();
}

// Two emulated ODrives and ChassisCan, which is on; the test is its pilot.
class CanProgramTest : public ModulesTest {
 protected:
  void SetUp() override {
    if (!run({"ip", "link", "add", kBus, "type", "vcan"}))
      GTEST_SKIP() << "no vcan: tools/dev vm-test";
    ASSERT_TRUE(run({"ip", "link", "set", kBus, "up"}));
    ModulesTest::SetUp();
    auto motors = ChildProcess::start(
        {std::string(TIMS_PROGRAMS) + "/rack-emulate", "odrives", "can:" + std::string(kBus)});
    ASSERT_TRUE(motors);
    motors_ = std::move(*motors);
    ASSERT_TRUE(motors_->wait_for_line("for driver"));
    driver_ = &start("ChassisCan",
                     {"--device=can:" + std::string(kBus), "--gearRatio=5", "--errorTimeout=100"});
    bus_ = opened();
    ASSERT_TRUE(bus_);
    const auto on = chassis().on();
    ASSERT_TRUE(on) << on.error().message();
    ASSERT_TRUE(chassis().set_active_pilot(Address(kWork)));
  }
  void TearDown() override { run({"ip", "link", "del", kBus}); }

  static std::unique_ptr<device::Transport> opened() {
    auto bus = device::open_transport(*device::DeviceAddress::parse("can:" + std::string(kBus)), 0);
    EXPECT_TRUE(bus) << bus.error().message();
    return bus ? std::move(*bus) : nullptr;
  }
  rack::ChassisProxy chassis() { return proxy<rack::ChassisProxy>(kChassis); }

  // The last speed command to the first motor, in turns per second.
  double speed() {
    (void)bus_->receive(os::now(), [this](const device::Arrival& frame) {
      if (frame.id != device::odrive_id(1, device::OdriveCommand::kEncoder) ||
          frame.bytes.size() < 8)
        return;
      speed_ = static_cast<double>(
          std::bit_cast<float>(device::little_endian<std::uint32_t>(frame.bytes, 4)));
    });
    return speed_;
  }
  // Sends MOVE as a pilot; each is valid for a limited time.
  testing::AssertionResult drives(const char* when) {
    return eventually(
        [&] { return chassis().move(300, 0, 0) && chassis().get_data() && speed() > 0.1; }, when);
  }
  testing::AssertionResult stands(const char* when) {
    return eventually([&] { return std::abs(speed()) < 0.01; }, when);
  }

  std::optional<ChildProcess> motors_;
  ChildProcess* driver_ = nullptr;
  std::unique_ptr<device::Transport> bus_;
  double speed_ = 0;
};

TEST_F(CanProgramTest, AVehicleDrivesAndStopsWithoutItsPilotOrItsDriver) {
  ASSERT_TRUE(drives("it drives"));
  ASSERT_TRUE(stands("its pilot is silent"));
  ASSERT_TRUE(drives("it continues"));
  kill("ChassisCan");
  EXPECT_TRUE(stands("its driver was killed"));
}

// 1 Mbit/s can carry about 9000 frames per second.
TEST_F(CanProgramTest, AFullBusDoesNotStopTheVehicle) {
  const auto noise = opened();
  std::atomic<std::uint64_t> sent = 0;
  std::jthread others([&](const std::stop_token& stop) {
    constexpr std::array<std::byte, 8> kNothing{};
    while (!stop.stop_requested()) {
      for (const std::uint32_t id : {0x001U, 0x6FFU, 0x80012345U})
        for (int i = 0; i < 3; ++i)
          if (const auto taken = noise->send(os::now(), kNothing, id); taken && *taken) ++sent;
      pollfd wait{.fd = noise->descriptor(), .events = POLLIN, .revents = 0};
      ::poll(&wait, 1, 1);
      (void)noise->receive(os::now(), [](const device::Arrival&) {});
    }
  });
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(drives("it drives at a full bus")) << i;
  ASSERT_TRUE(eventually([&] { return sent > 5000; }, "so many others"));
  ASSERT_TRUE(drives("it drives on"));
  EXPECT_EQ(*chassis().status(), rack::Status::kEnabled);
  EXPECT_TRUE(stands("its pilot is silent"));
}

// The controller reports bus-off repeatedly.
TEST_F(CanProgramTest, AStormOfBusOffIsReportedInFewLinesAndPasses) {
  ASSERT_TRUE(drives("it drives"));
  const auto controller = opened();
  constexpr std::uint32_t kBusOff = 0x20000040;  // as in linux/can/error.h
  constexpr std::array<std::byte, 8> kNoMore{};
  const Time begin = os::now();
  for (int i = 0; i < 100; ++i) {
    for (int k = 0; k < 10; ++k) ASSERT_TRUE(controller->send(os::now(), kNoMore, kBusOff));
    (void)chassis().get_data();
  }
  const auto seconds = (os::now() - begin) / 1s;
  ASSERT_TRUE(driver_->wait_for_line("is bus-off"));
  EXPECT_TRUE(eventually(
      [&] {
        (void)chassis().set_active_pilot(Address(kWork));
        return chassis().move(300, 0, 0) && speed() > 0.1;
      },
      "it drives again"));
  const std::string output = driver_->output();
  std::int64_t times = 0;
  for (std::size_t at = output.find("is bus-off"); at != std::string::npos;
       at = output.find("is bus-off", at + 1))
    ++times;
  EXPECT_LE(times, 2 * seconds + 4) << output;
}

}  // namespace devices_vm_test
}  // namespace tims::test
