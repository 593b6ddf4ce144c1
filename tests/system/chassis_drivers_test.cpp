// Drivers of chassis, real programs, with emulated robots at pseudo terminals: they drive, and they
// stand whenever nobody drives them any more, also when the driver is killed.
#include <functional>
#include <mutex>
#include <thread>

#include <fcntl.h>
#include <unistd.h>

#include "devices/emulators/er1_robot.h"
#include "devices/emulators/motor_bus.h"
#include "devices/emulators/pioneer.h"
#include "devices/emulators/roomba_robot.h"
#include "devices/emulators/rover.h"
#include "devices/io/device.h"
#include "os/clock.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/servo_drive.h"
#include "tests/support/eventually.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace {

namespace device = rack::device;

// A robot at the other end of a terminal, which lives in a thread of its own.
class EmulatedRobot {
 public:
  EmulatedRobot(std::unique_ptr<device::Dialogue> robot, std::function<bool()> stands,
                const std::string& address)
      : stands_(std::move(stands)), robot_(std::move(robot)) {
    auto line = device::open_transport(*device::DeviceAddress::parse("pty:" + address), 115200);
    EXPECT_TRUE(line) << line.error().message();
    device_ = device::Device::with(std::move(*line), nullptr, *robot_);
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        {
          const std::lock_guard lock(mutex_);
          (void)device_->wait(os::now());
        }
        std::this_thread::sleep_for(500us);  // whoever asks gets the lock
      }
    });
  }
  ~EmulatedRobot() { thread_ = {}; }

  // What its wheels are told.
  bool is_told_to_stand() {
    const std::lock_guard lock(mutex_);
    return stands_();
  }

 private:
  std::mutex mutex_;
  std::function<bool()> stands_;
  std::unique_ptr<device::Dialogue> robot_;
  std::unique_ptr<device::Device> device_;
  std::jthread thread_;
};

struct Driver {
  std::string program;
  std::vector<std::string> arguments;
  std::function<std::unique_ptr<EmulatedRobot>(const std::string& address)> robot;
  Duration alone;         // how long the robot goes on without its driver, at most
  Duration begins = 0ms;  // how long it takes until it obeys
  std::string options{};  // of the address
};

void PrintTo(const Driver& driver, std::ostream* out) { *out << driver.program; }

template <class Emulator, typename... Arguments>
auto making(Arguments... arguments) {
  return [=](const std::string& address) {
    auto robot = std::make_unique<Emulator>(arguments...);
    const auto& body = robot->body();
    return std::make_unique<EmulatedRobot>(
        std::move(robot), [&body] { return body.is_told_to_stand(); }, address);
  };
}

// Motors at a bus, of nodes 1, 2, and so on.
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

const std::array kDrivers = {
    Driver{"ChassisPioneer", {}, making<device::PioneerEmulator>(), 2500ms},
    Driver{"ChassisRoomba",
           {},
           making<device::RoombaEmulator>(device::RoombaModel::kRoomba),
           kSlowdown * 300ms},
    Driver{"ChassisRoomba",
           {"--model=1"},
           making<device::RoombaEmulator>(device::RoombaModel::kCreate2),
           kSlowdown * 300ms},
    Driver{"ChassisEr1", {}, making<device::Er1Emulator>(), kSlowdown * 300ms},
    Driver{"MavlinkVehicle", {"--arm=1", "--mode=15"}, making<device::RoverEmulator>(), 3500ms, 3s},
    Driver{"ChassisCan",
           {"--controller=0", "--gearRatio=5"},
           making_motors(
               2, [](std::uint8_t node) { return std::make_unique<device::OdriveEmulator>(node); }),
           kSlowdown * 500ms,
           0ms,
           "?can=500000"},
    Driver{
        "ChassisCan",
        {"--controller=1"},
        making_motors(
            2, [](std::uint8_t node) { return std::make_unique<device::VescEmulator>(node, 7); }),
        1500ms,
        0ms,
        "?can=500000"},
    Driver{"Chassis402", {}, making_motors(2, make_drive), kSlowdown * 500ms, 0ms, "?can=1000000"},
    Driver{
        "ChassisRobucar", {}, making_motors(6, make_drive), kSlowdown * 500ms, 0ms, "?can=1000000"},
};

class ChassisDriversTest : public RobotTest, public testing::WithParamInterface<Driver> {
 protected:
  void SetUp() override {
    RobotTest::SetUp();
    path_ = "/tmp/chassis-" + std::to_string(::getpid());
    robot_ = GetParam().robot(path_ + GetParam().options);
    auto arguments = GetParam().arguments;
    arguments.push_back("--device=serial:" + path_ + GetParam().options);
    start(GetParam().program, arguments);
    ASSERT_TRUE(turned_on("Chassis(0/0)"));
    ASSERT_TRUE(chassis().set_active_pilot(Address(kWork)).ok());
    std::this_thread::sleep_for(GetParam().begins);
  }
  rack::ChassisProxy chassis() { return proxy<rack::ChassisProxy>("Chassis(0/0)"); }

  // As a pilot of 20 Hz; afterwards it drives.
  void drive_for(Duration how_long) {
    auto chassis = this->chassis();
    const Time end = os::now() + how_long;
    while (os::now() < end) {
      const auto moved = chassis.move(200, 0, 0.1F);
      ASSERT_TRUE(moved) << moved.error().message();
      std::this_thread::sleep_for(50ms);
    }
    EXPECT_FALSE(robot_->is_told_to_stand());
  }
  testing::AssertionResult stands_within(Duration limit) {
    return eventually(
        [&]() -> std::string { return robot_->is_told_to_stand() ? "" : "the robot drives on"; },
        limit);
  }

  std::string path_;
  std::unique_ptr<EmulatedRobot> robot_;
};

TEST_P(ChassisDriversTest, StandsWhenItsPilotIsSilent) {
  drive_for(1s);
  EXPECT_TRUE(stands_within(kSlowdown * 400ms));
  drive_for(500ms);  // and goes on
}

TEST_P(ChassisDriversTest, StandsWhenAnotherPilotIsChosen) {
  drive_for(1s);
  ASSERT_TRUE(chassis().set_active_pilot(Address(0x00180000)).ok());
  EXPECT_TRUE(stands_within(kSlowdown * 120ms));
  EXPECT_FALSE(chassis().move(200, 0, 0).ok());
}

TEST_P(ChassisDriversTest, StandsWhenItIsTurnedOff) {
  drive_for(1s);
  ASSERT_TRUE(chassis().off().ok());
  EXPECT_TRUE(stands_within(kSlowdown * 120ms));
}

TEST_P(ChassisDriversTest, StandsWhenItsDriverIsKilled) {
  drive_for(1s);
  kill(GetParam().program);
  EXPECT_TRUE(stands_within(GetParam().alone));
  // Nobody holds the line: another driver takes over.
  auto arguments = GetParam().arguments;
  arguments.push_back("--device=serial:" + path_ + GetParam().options);
  start(GetParam().program, arguments);
  EXPECT_TRUE(turned_on("Chassis(0/0)"));
}

// Unplugged for a moment: the robot drives on when its pilot does, and nobody has to do anything.
TEST_P(ChassisDriversTest, ComesBackWithItsLine) {
  drive_for(500ms);
  robot_.reset();
  EXPECT_TRUE(eventually([&]() -> std::string {
    return chassis().move(200, 0, 0).ok() ? "the driver has not noticed" : "";
  }));
  robot_ = GetParam().robot(path_ + GetParam().options);
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto moved = chassis().move(200, 0, 0);
    return moved.ok() ? "" : moved.error().message();
  }));
  EXPECT_TRUE(turned_on("Chassis(0/0)"));
  std::this_thread::sleep_for(GetParam().begins);
  drive_for(500ms);
}

INSTANTIATE_TEST_SUITE_P(Drivers, ChassisDriversTest, testing::ValuesIn(kDrivers),
                         [](const auto& driver) {
                           return driver.param.program + std::to_string(driver.index);
                         });

class ServoDriveTest : public RobotTest {};

TEST_F(ServoDriveTest, GoesWhereItIsToldAndTellsThatItIsThere) {
  const std::string path = "/tmp/servo-" + std::to_string(::getpid());
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
  ASSERT_TRUE(servo.home());
  EXPECT_TRUE(eventually([&]() -> std::string {
    const auto data = servo.get_data();
    return data && std::abs(data->position) < 0.01F ? "" : "it is not at home";
  }));
}

class MavlinkPartsTest : public RobotTest {};

TEST_F(MavlinkPartsTest, AllOfThemHaveTheirDataAndEndTogether) {
  const std::string path = "/tmp/chassis-parts-" + std::to_string(::getpid());
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

}  // namespace
}  // namespace tims::test
