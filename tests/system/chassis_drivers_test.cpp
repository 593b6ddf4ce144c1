// Chassis drivers as real programs, with emulated robots at pseudo terminals: the robots drive, and
// they stop whenever commands end, also when the driver is killed.
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "components/devices/camera/ptz_camera.h"
#include "components/devices/chassis/er1_robot.h"
#include "components/devices/chassis/motor_bus.h"
#include "components/devices/chassis/pioneer.h"
#include "components/devices/chassis/roomba_robot.h"
#include "components/devices/chassis/rover.h"
#include "os/clock.h"
#include "os/wakeup.h"
#include "rack/devices/device.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/ptz_drive.h"
#include "rack/proxies/servo_drive.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace chassis_drivers_test {

namespace device = rack::device;

// A robot at the other end of a terminal, emulated in a separate thread. It reports the commands to
// its wheels.
class EmulatedRobot {
 public:
  EmulatedRobot(std::unique_ptr<device::Dialogue> robot, std::function<bool()> stands,
                const std::string& address)
      : robot_(std::move(robot)), ended_(std::move(*os::make_event_fd())) {
    auto line = device::open_transport(*device::DeviceAddress::parse("pty:" + address), 115200);
    EXPECT_TRUE(line) << line.error().message();
    device_ = device::Device::with(std::move(*line), *robot_);
    thread_ = std::jthread([this, stands = std::move(stands)](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        const auto waited = device_->wait(tims::kNever, ended_.get());
        ASSERT_TRUE(waited) << waited.error().message();
        update(stands());
      }
    });
  }
  ~EmulatedRobot() {
    thread_.request_stop();
    os::signal_event_fd(ended_.get());
    thread_.join();
  }

  testing::AssertionResult stands_within(Duration limit) {
    if (becomes(true, limit)) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "the robot drives on for " << limit / 1ms << " ms";
  }
  bool drives_within(Duration limit) { return becomes(false, limit); }

 private:
  void update(bool stands) {
    const std::lock_guard lock(mutex_);
    if (std::exchange(stands_, stands) != stands) changed_.notify_all();
  }
  bool becomes(bool standing, Duration limit) {
    std::unique_lock lock(mutex_);
    return changed_.wait_until(lock, std::chrono::steady_clock::now() + limit,
                               [&] { return stands_ == standing; });
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stands_ = true;
  std::unique_ptr<device::Dialogue> robot_;
  std::unique_ptr<device::Device> device_;
  os::File ended_;
  std::jthread thread_;
};

// Time within which a stop command takes effect; a later stop is due to the robot's own watchdog.
constexpr Duration kSoon = kSlowdown * 500ms;
// Validity of MOVE from a pilot that sends 50 per second, or has not announced its period.
constexpr Duration kMoveHolds = 300ms;

struct Driver {
  std::string program;
  std::vector<std::string> arguments;
  std::function<std::unique_ptr<EmulatedRobot>(const std::string& address)> robot;
  // How long the robot continues without its driver. 0: the driver's guard process stops it, long
  // before a watchdog of the robot.
  Duration watchdog;
  std::string options{};  // options of the address
};

void PrintTo(const Driver& driver, std::ostream* out) { *out << driver.program; }

template <class Emulator, typename... Arguments>
auto making(Arguments... arguments) {
  return [=](const std::string& address) {
    auto robot = std::make_unique<Emulator>(arguments...);
    const auto& body = robot->body();
    return std::make_unique<EmulatedRobot>(
        std::move(robot), [&body] { return body.must_stop(); }, address);
  };
}

// Motors at a bus, with node numbers 1, 2, and so on.
using MakeMotor = std::function<std::unique_ptr<device::EmulatedMotor>(std::uint8_t node)>;
auto making_motors(std::uint8_t count, MakeMotor make) {
  return [count, make = std::move(make)](const std::string& address) {
    auto bus = std::make_unique<device::MotorBus>();
    for (std::uint8_t node = 1; node <= count; ++node) bus->add(make(node));
    const auto stands = [count, motors = bus.get()] {
      for (std::size_t i = 0; i < count; ++i)
        if (motors->motor(i).shaft().wanted() != 0) return false;
      return true;
    };
    return std::make_unique<EmulatedRobot>(std::move(bus), stands, address);
  };
}
std::unique_ptr<device::EmulatedMotor> make_drive(std::uint8_t node) {
  return std::make_unique<device::Cia402Emulator>(node, 4096, 4096);
}
// In its factory settings: without a watchdog.
std::unique_ptr<device::EmulatedMotor> make_odrive(std::uint8_t node) {
  auto odrive = std::make_unique<device::OdriveEmulator>(node);
  odrive->has_watchdog = false;
  return odrive;
}

const std::array kDrivers = {
    Driver{"ChassisPioneer", {}, making<device::PioneerEmulator>(), 2s},
    Driver{"ChassisRoomba", {}, making<device::RoombaEmulator>(device::RoombaModel::kRoomba), 0s},
    Driver{"ChassisRoomba",
           {"--model=1"},
           making<device::RoombaEmulator>(device::RoombaModel::kCreate2),
           0s},
    Driver{"ChassisEr1", {}, making<device::Er1Emulator>(), 0s},
    Driver{"MavlinkVehicle", {"--arm=1", "--mode=15"}, making<device::RoverEmulator>(), 3s},
    Driver{"ChassisCan",
           {"--controller=0", "--gearRatio=5"},
           making_motors(2, make_odrive),
           0s,
           "?can=500000"},
    Driver{
        "ChassisCan",
        {"--controller=1"},
        making_motors(
            2, [](std::uint8_t node) { return std::make_unique<device::VescEmulator>(node, 7); }),
        0s,
        "?can=500000"},
    Driver{"Chassis402", {}, making_motors(2, make_drive), 0s, "?can=1000000"},
    Driver{"ChassisRobucar", {}, making_motors(6, make_drive), 0s, "?can=1000000"},
};

class ChassisDriversTest : public RobotTest, public testing::WithParamInterface<Driver> {
 protected:
  void SetUp() override {
    RobotTest::SetUp();
    plug_in();
    start_driver();
    ASSERT_TRUE(chassis().set_active_pilot(Address(kWork)).ok());
  }
  void plug_in() { robot_ = GetParam().robot(path() + GetParam().options); }
  void start_driver() {
    auto arguments = GetParam().arguments;
    arguments.push_back("--device=serial:" + path() + GetParam().options);
    start(GetParam().program, arguments);
    ASSERT_TRUE(turned_on("Chassis(0/0)"));
  }
  [[nodiscard]] std::string path() const { return folder_.path() / "robot"; }
  rack::ChassisProxy chassis() { return proxy<rack::ChassisProxy>("Chassis(0/0)"); }

  // Sends MOVE at 50 Hz until the robot drives. On a busy machine the robot's watchdog may stop it
  // once; the driver is off for a moment, and the pilot continues.
  void drive() {
    auto chassis = this->chassis();
    const Time end = os::now() + kPatience;
    do {
      const auto moved = chassis.move(200, 0, 0.1F);
      ASSERT_LT(os::now(), end) << "the robot does not drive: "
                                << (moved ? "it receives MOVE" : moved.error().message());
    } while (!robot_->drives_within(20ms));
  }

  TemporaryFolder folder_;
  std::unique_ptr<EmulatedRobot> robot_;
};

TEST_P(ChassisDriversTest, StopsWhenItsPilotIsSilent) {
  drive();
  EXPECT_TRUE(robot_->stands_within(kMoveHolds + kSoon));
  drive();  // and continues
}

TEST_P(ChassisDriversTest, StopsWhenAnotherPilotIsSelected) {
  drive();
  ASSERT_TRUE(chassis().set_active_pilot(Address(0x00180000)).ok());
  EXPECT_TRUE(robot_->stands_within(kSoon));
  EXPECT_FALSE(chassis().move(200, 0, 0).ok());
}

TEST_P(ChassisDriversTest, StopsWhenItIsTurnedOff) {
  drive();
  ASSERT_TRUE(chassis().off().ok());
  EXPECT_TRUE(robot_->stands_within(kSoon));
}

TEST_P(ChassisDriversTest, StopsWhenItsDriverIsKilled) {
  drive();
  kill(GetParam().program);
  EXPECT_TRUE(robot_->stands_within(GetParam().watchdog + kSoon));
  // The line is free, so another driver can open it.
  start_driver();
}

// The pilot may be running, but its commands no longer arrive.
TEST_P(ChassisDriversTest, StopsWhenItsRouterIsKilled) {
  drive();
  router_.kill();
  EXPECT_TRUE(robot_->stands_within(kMoveHolds + kSoon));
  // The pilot need not be selected again.
  ASSERT_TRUE(router_.start().ok());
  drive();
}

// The line is unplugged for a moment: the robot drives again when its pilot does, without any other
// action.
TEST_P(ChassisDriversTest, ContinuesAfterItsLineIsReplugged) {
  drive();
  robot_.reset();
  EXPECT_TRUE(eventually([&]() -> std::string {
    return chassis().move(200, 0, 0).ok() ? "the driver has not noticed" : "";
  }));
  plug_in();
  drive();
}

INSTANTIATE_TEST_SUITE_P(Drivers, ChassisDriversTest, testing::ValuesIn(kDrivers),
                         [](const auto& driver) {
                           return driver.param.program + std::to_string(driver.index);
                         });

class ServoDriveTest : public RobotTest {};

TEST_F(ServoDriveTest, MovesToItsTargetAndReportsItsArrival) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "servo";
  const auto axis = making_motors(1, make_drive)(path + "?can=125000");
  start("ServoDrive", {"--gearRatio=10", "--device=serial:" + path + "?can=125000"});
  ASSERT_TRUE(turned_on("ServoDrive(0/0)"));
  auto servo = proxy<rack::ServoDriveProxy>("ServoDrive(0/0)");
  const auto moved = servo.move_pos({.position = 0.5F});
  ASSERT_TRUE(moved) << moved.error().message();
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto data = servo.get_data();
    if (!data) return data.error().message();
    const bool is_there = std::abs(data->position - 0.5F) < 0.01F;
    return is_there ? "" : "it is at " + std::to_string(data->position);
  }));
  const auto newest = servo.get_data();
  ASSERT_TRUE(newest);
  const rack::TimeStamp between = newest->recordingTime - std::chrono::milliseconds(7);
  EXPECT_EQ(servo.get_data(between)->recordingTime, between) << "between two data sets";
  ASSERT_TRUE(servo.home());
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto data = servo.get_data();
    return data && std::abs(data->position) < 0.01F ? "" : "it is not at home";
  }));
}

// A turning mount must stop whichever program crashes.
class PtzDriveTest : public RobotTest {
 protected:
  void SetUp() override {
    RobotTest::SetUp();
    auto camera = std::make_unique<device::emulator::PtzCamera>();
    const auto* const seen = camera.get();
    camera_.emplace(
        std::move(camera), [seen] { return seen->stands(); }, folder_.path() / "mount");
    start("PtzDrive", {"--device=serial:" + (folder_.path() / "mount").string()});
    ASSERT_TRUE(turned_on("PtzDrive(0/0)"));
    auto drive = proxy<rack::PtzDriveProxy>("PtzDrive(0/0)");
    const auto moved = drive.move_vel({.velPan = 0.2F});
    ASSERT_TRUE(moved) << moved.error().message();
    ASSERT_TRUE(camera_->drives_within(kPatience));
  }
  TemporaryFolder folder_;
  std::optional<EmulatedRobot> camera_;
};

TEST_F(PtzDriveTest, StopsWithoutFurtherCommands) {
  EXPECT_TRUE(camera_->stands_within(kMoveHolds + kSoon));
}

TEST_F(PtzDriveTest, StopsWhenItsDriverIsKilled) {
  kill("PtzDrive");
  EXPECT_TRUE(camera_->stands_within(kSoon));
}

class MavlinkPartsTest : public RobotTest {};

TEST_F(MavlinkPartsTest, AllHaveDataAndExitTogether) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "rover";
  const auto rover = making<device::RoverEmulator>()(path);
  auto& program = ModulesTest::start(
      "MavlinkVehicle", {"--errorTimeout=100", "--positionInst=2", "--device=serial:" + path});
  ASSERT_TRUE(turned_on("Chassis(0/0)"));
  ASSERT_TRUE(turned_on("Gps(0/0)"));
  ASSERT_TRUE(turned_on("Gyro(0/0)"));
  ASSERT_TRUE(turned_on("Position(0/2)"));
  const auto gps = proxy<rack::GpsProxy>("Gps(0/0)").get_data();
  ASSERT_TRUE(gps) << gps.error().message();
  EXPECT_EQ(gps->satelliteNum, 11);
  const auto position = proxy<rack::PositionProxy>("Position(0/2)").get_data();
  ASSERT_TRUE(position) << position.error().message();
  EXPECT_EQ(position->pos.z.raw(), -500);
  const auto ended = program.stop(SIGTERM);
  ASSERT_TRUE(ended) << ended.error().message();
}

}  // namespace chassis_drivers_test
}  // namespace tims::test
