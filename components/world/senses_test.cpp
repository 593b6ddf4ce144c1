// Drivers' dialogues, emulators and a world between them, on a simulated clock: drivers report the
// truth, and their commands are executed.
#include "components/world/senses.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/devices/chassis/motor_bus.h"
#include "components/devices/chassis/motor_chassis.h"
#include "components/devices/chassis/p2os.h"
#include "components/devices/chassis/pioneer.h"
#include "components/devices/chassis/servo_axis.h"
#include "components/devices/positioning/cmps03.h"
#include "components/devices/positioning/nmea_receiver.h"
#include "components/devices/positioning/xsens.h"
#include "components/devices/scanners/lms200.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace senses_test {

using namespace std::chrono_literals;
using world::SensorKind;

constexpr Time kBegin{1000s};  // of virtual lines

world::SensorDescription sensor(std::string name, SensorKind kind) {
  return {.name = std::move(name), .kind = kind};
}

// A hall of 20 m by 20 m, and a robot in its middle that looks to the north.
world::WorldDescription hall() {
  world::WorldDescription hall;
  constexpr double kFar = 10000;
  hall.ground = {{-kFar, -kFar}, {kFar, kFar}};
  const std::array<MapPoint, 5> corners = {
      {{-kFar, -kFar}, {-kFar, kFar}, {kFar, kFar}, {kFar, -kFar}, {-kFar, -kFar}}};
  for (std::size_t i = 0; i < 4; ++i) hall.walls.push_back({corners[i], corners[i + 1]});
  hall.origin = {.latitude = radians(52), .longitude = radians(9)};
  world::RobotDescription robot{.name = "scout", .track = 400, .device = "pioneer"};
  robot.sensors = {sensor("laser", SensorKind::kScanner), sensor("gps", SensorKind::kSatellite),
                   sensor("gyro", SensorKind::kInertial), sensor("compass", SensorKind::kCompass)};
  hall.robots.push_back(robot);
  return hall;
}

// An emulated device, whose world goes on with its clock.
class InWorld final : public Dialogue {
 public:
  InWorld(Dialogue& device, world::World& world, std::span<Drivetrain> trains)
      : device_(device), world_(world), trains_(trains), truth_(world.make_truth()) {}

  void start(Time now, Output& out) override { device_.start(now, out); }
  void on_arrival(const Arrival& arrival, Output& out) override {
    go_on(world_, trains_, arrival.last, truth_);
    device_.on_arrival(arrival, out);
  }
  void on_timeout(Time now, Output& out) override {
    go_on(world_, trains_, now, truth_);
    if (device_.next_timeout() <= now) device_.on_timeout(now, out);
  }
  [[nodiscard]] Time next_timeout() const override {
    return std::min(device_.next_timeout(), world_.now() + Duration(1));
  }

 private:
  Dialogue& device_;
  world::World& world_;
  std::span<Drivetrain> trains_;
  world::Truth truth_;
};

class SensesTest : public testing::Test {
 protected:
  explicit SensesTest(world::WorldDescription description = hall())
      : world_(std::move(*world::World::make(std::move(description), kBegin))) {}

  [[nodiscard]] std::unique_ptr<Dialogue> sensing(const char* emulator, const char* name) const {
    return find_emulator(emulator)->make(
        scene_of(world_, *world_.find_sensor("scout", name), 20454 * 24h));
  }
  void turn(double omega) {
    world_.drive(0, ChassisSpeed{.omega = static_cast<float>(omega)}, world_.now());
  }
  [[nodiscard]] world::RobotTruth robot() const {
    auto truth = world_.make_truth();
    world_.truth(truth);
    return truth.robots[0];
  }
  // The newest data that the driver's dialogue has reported within that time.
  template <class Data, class Dialog>
  Data newest(Dialog& driver, Dialogue& emulator, const emulator::LineSettings& settings,
              Duration within) {
    InWorld device(emulator, world_, trains_);
    emulator::VirtualLine line(driver, device, settings);
    line.start();
    Data newest{};
    Time recorded{};
    bool has_any = false;
    line.run(within, [&] {
      has_any = driver.take(newest, recorded) || has_any;
      return false;
    });
    EXPECT_TRUE(has_any);
    return newest;
  }

  world::World world_;
  std::vector<Drivetrain> trains_;
};

constexpr emulator::LineSettings serial(std::uint32_t baud) {
  return {.has_rate = true, .host_baud = baud, .device_baud = baud};
}

TEST_F(SensesTest, APioneerIsWhereItsOdometryIs) {
  PioneerEmulator pioneer;
  trains_.push_back(*Drivetrain::make(world_, 0, pioneer));
  P2os driver{P2osSettings{}};
  InWorld device(pioneer, world_, trains_);
  emulator::VirtualLine line(driver, device, serial(9600));
  line.start();
  ASSERT_TRUE(line.run(20s, [&] { return driver.is_ready(); }));
  Pose reckoned;
  ChassisData data;
  Time recorded{};
  const auto drive = [&](const ChassisSpeed& speed, Duration how_long) {
    const Time end = line.now() + how_long;
    while (line.now() < end) {
      driver.drive(speed, line.now());
      line.run(50ms);
      while (driver.take(data, recorded))
        reckoned = reckoned + Pose{.x = static_cast<double>(data.deltaX.raw()),
                                   .rho = static_cast<double>(data.deltaRho.raw())};
    }
  };
  drive({.vx = 400}, 5s);
  drive({.vx = 200, .omega = 0.4F}, 5s);
  drive({}, 3s);
  const world::RobotTruth truth = robot();
  EXPECT_GT(truth.pose.x, 1500);
  EXPECT_GT(truth.pose.rho, 1.5) << "clockwise";
  EXPECT_NEAR(truth.pose.x, reckoned.x, 60);
  EXPECT_NEAR(truth.pose.y, reckoned.y, 60);
  EXPECT_NEAR(truth.pose.rho, reckoned.rho, 0.05);
  EXPECT_NEAR(truth.vx, 0, 1e-6);
}

// With gears: shafts report turns, rims move.
TEST(SensesOfACar, MotorsBehindGearsMoveIt) {
  world::WorldDescription field = hall();
  field.robots[0].kind = world::DriveKind::kDoubleAckermann;
  field.robots[0].wheel_radius = 200;
  field.robots[0].gear_ratio = 20;
  field.robots[0].steer_ratio = 10;
  field.robots[0].device = "robucar";
  auto made = world::World::make(field, kBegin);
  ASSERT_TRUE(made) << made.error().message();
  class Motors final : public emulator::Wheelwork {
   public:
    [[nodiscard]] std::size_t motor_count() const override { return 6; }
    [[nodiscard]] bool reports_shafts() const override { return true; }
    void set_lag(Duration /*lag*/) override {}
    void turned(Time now, std::span<double> positions) override {
      const double seconds = std::chrono::duration<double>(now - kBegin).count();
      std::ranges::fill(positions.first(4), 100 * seconds);  // 1000 mm/s of the rims
      positions[4] = 2;                                      // 0.2 rad of the steering
      positions[5] = -2;
    }
  } motors;
  std::vector trains{*Drivetrain::make(*made, 0, motors)};
  auto truth = made->make_truth();
  for (Time now = kBegin; now < kBegin + 2s; now += 7ms) go_on(*made, trains, now, truth);
  EXPECT_NEAR(truth.robots[0].travelled, 2000, 80);
  EXPECT_NEAR(truth.robots[0].vx, 1000, 60);
  EXPECT_NEAR(truth.robots[0].omega, 1000 * 2 * std::tan(0.2) / 1200, 0.05) << "to the right";

  PioneerEmulator two;
  EXPECT_FALSE(Drivetrain::make(*made, 0, two)) << "six wheels to turn, and two motors";
}

// A drive tilts the scanner: the scanner measures at the angle that the driver of the axis reports.
TEST(SensesOfAnAxis, TheScannerLooksWhereTheDrivePoints) {
  world::WorldDescription field = hall();
  field.robots[0].sensors[0].mount = {.z = -1000};
  field.robots[0].sensors[0].axis = {
      .about = world::TurnedAbout::kPitch, .gear_ratio = 10, .device = "servo"};
  auto made = world::World::make(field, kBegin);
  ASSERT_TRUE(made) << made.error().message();
  const auto emulated = servo();
  auto& bus = dynamic_cast<MotorBus&>(*emulated);
  std::vector trains{*Drivetrain::make(*made, world::SensorId{0, 0}, bus)};
  ServoAxis driver({.drive = {.acceleration = 70}, .gear = 10, .velocity_max = 1});
  InWorld device(bus, *made, trains);
  emulator::VirtualLine line(driver, device, serial(500000));
  line.start();
  ASSERT_TRUE(line.run(5s, [&] { return driver.is_ready(); }));
  driver.move_to(radians(-35), radians(60), 0);
  ServoDriveData reported;
  Time recorded{};
  int compared = 0;
  line.run(400ms, [&] {
    if (driver.take(reported, recorded) && reported.position < radians(-5)) {
      ++compared;
      const double range = made->look({0, 0}, {}, recorded).range;
      EXPECT_NEAR(std::asin(1000 / range), -static_cast<double>(reported.position), radians(0.2));
    }
    return false;
  });
  EXPECT_GT(compared, 3);
  line.run(1s, [] { return false; });
  EXPECT_NEAR(made->axis({0, 0}, made->now()), radians(-35), 1e-3);

  PioneerEmulator two;
  EXPECT_FALSE(Drivetrain::make(*made, world::SensorId{0, 0}, two)) << "an axis has one motor";
}

TEST_F(SensesTest, AScannerSeesTheWallComeNearer) {
  const auto emulated = sensing("lms200", "laser");
  Lms200 driver({.baud = 38400});
  world_.drive(0, ChassisSpeed{.vx = 500}, kBegin);
  const auto scan = newest<LadarData>(driver, *emulated, serial(38400), 12s);
  ASSERT_EQ(scan.points.size(), 361U);
  const double ahead = 10000 - robot().pose.x;
  EXPECT_LT(ahead, 4500);
  EXPECT_NEAR(scan.points[180].distance.raw(), ahead, 500) << "of some moments ago";
  EXPECT_NEAR(scan.points[0].distance.raw(), 10000, 5);
}

TEST_F(SensesTest, AnInertialSensorTurnsClockwiseAsTheRobotDoes) {
  const auto emulated = sensing("xsens", "gyro");
  Xsens driver{XsensSettings{.mounting = XsensMounting::kLabelUp}};
  turn(0.3);
  const auto gyro = newest<GyroData>(driver, *emulated, serial(115200), 3s);
  EXPECT_NEAR(static_cast<double>(gyro.wYaw.raw()), 0.3, 0.01);
  EXPECT_NEAR(signed_angle(static_cast<double>(gyro.yaw.raw()) - robot().pose.rho), 0, 0.05);
  EXPECT_NEAR(static_cast<double>(gyro.roll.raw()), 0, 0.01);
}

TEST_F(SensesTest, ACompassPointsWhereTheRobotLooks) {
  const auto emulated = sensing("cmps03", "compass");
  Cmps03 driver{Cmps03Settings{}};
  turn(0.3);
  const auto compass = newest<CompassData>(driver, *emulated, serial(57600), 3s);
  EXPECT_NEAR(signed_angle(static_cast<double>(compass.orientation.raw()) - robot().pose.rho), 0,
              0.06);
}

TEST_F(SensesTest, AReceiverGetsThePositionOnEarth) {
  const auto emulated = sensing("nmea", "gps");
  NmeaReceiver driver{NmeaSettings{}};
  world_.drive(0, ChassisSpeed{.vx = 1000}, kBegin);
  const auto fix = newest<GpsData>(driver, *emulated, serial(4800), 6s);
  EXPECT_GT(fix.mode, 1);
  const double north = (degrees(fix.latitude.raw()) - 52) * 111195;
  EXPECT_NEAR(north, robot().pose.x / 1000, 3);
  EXPECT_GT(north, 2);
  EXPECT_NEAR(static_cast<double>(fix.speed.raw()), 1000, 20);
}

TEST_F(SensesTest, AReceiverHasThePeriodOfItsDescription) {
  auto description = hall();
  description.robots[0].sensors[1].period = 2s;
  auto made = world::World::make(description, kBegin);
  ASSERT_TRUE(made);
  const auto emulated = find_emulator("nmea")->make(scene_of(*made, {0, 1}, {}));
  NmeaReceiver driver{NmeaSettings{.period = 2s}};
  emulator::VirtualLine line(driver, *emulated, serial(4800));
  line.start();
  GpsData fix;
  std::vector<Time> times;
  line.run(9s, [&] {
    Time recorded{};
    if (driver.take(fix, recorded)) times.push_back(recorded);
    return false;
  });
  ASSERT_EQ(times.size(), 5U);
  EXPECT_NEAR(static_cast<double>((times[4] - times[0]).count()), 8e9, 5e6);
}

// A lag of the motors also applies to their encoders: these never report what the wheels will do.
TEST(SensesOfALaggingRobot, EncodersReportWhatItsWheelsDo) {
  world::WorldDescription field = hall();
  field.robots[0].lag = 200ms;
  auto made = world::World::make(field, kBegin);
  ASSERT_TRUE(made) << made.error().message();
  class TwoShafts final : public emulator::Wheelwork {
   public:
    void turn(double speed) { shaft_.turn(speed); }
    [[nodiscard]] std::size_t motor_count() const override { return 2; }
    void set_lag(Duration lag) override { shaft_.set_lag(lag); }
    void turned(Time now, std::span<double> positions) override {
      shaft_.step(now);
      std::ranges::fill(positions, shaft_.position());
    }
    [[nodiscard]] double position() const { return shaft_.position(); }

   private:
    ShaftModel shaft_;
  } motors;
  std::vector trains{*Drivetrain::make(*made, 0, motors)};
  auto truth = made->make_truth();
  Time now = kBegin;
  const auto drive = [&](double speed, Duration how_long) {
    motors.turn(speed);
    for (const Time end = now + how_long; now < end; now += 5ms) {
      go_on(*made, trains, now, truth);
      EXPECT_NEAR(truth.robots[0].travelled, motors.position(), 15)
          << "at " << (now - kBegin) / 1ms << " ms";
    }
  };
  drive(0, 50ms);
  drive(500, 190ms);
  EXPECT_EQ(motors.position(), 0) << "not yet";
  drive(500, 2s);
  EXPECT_GT(motors.position(), 600);
  drive(0, 200ms);
  const double braking = motors.position();
  drive(0, 2s);
  EXPECT_GT(motors.position(), braking) << "it has rolled on";
}

// What a lag of its sensor makes late.
TEST_F(SensesTest, WhatLagsIsOfThePast) {
  auto description = hall();
  description.robots[0].sensors[0].lag = 200ms;
  auto made = world::World::make(description, kBegin);
  ASSERT_TRUE(made);
  made->drive(0, ChassisSpeed{.vx = 1000}, kBegin);
  made->advance(kBegin + 2s);
  const auto sight = scene_of(*made, {0, 0}, {}).sight;
  EXPECT_NEAR(sight(0, 0, kBegin + 2s), 10000 - 1800, 8);
  EXPECT_NEAR(sight(0, 0, kBegin + 1900ms), 10000 - 1700, 8);
}

}  // namespace senses_test
}  // namespace rack::device
