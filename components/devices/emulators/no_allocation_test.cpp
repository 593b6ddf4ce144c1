// Dialogues of vehicles, motors and boards allocate no memory during operation.
#include <gtest/gtest.h>

#include "components/devices/camera/ptz_camera.h"
#include "components/devices/chassis/er1_robot.h"
#include "components/devices/chassis/mavlink_vehicle.h"
#include "components/devices/chassis/motor_bus.h"
#include "components/devices/chassis/motor_chassis.h"
#include "components/devices/chassis/pioneer.h"
#include "components/devices/chassis/roomba_robot.h"
#include "components/devices/chassis/rover.h"
#include "components/devices/chassis/servo_axis.h"
#include "components/devices/pins/io_board.h"
#include "tests/support/counted_new.h"

namespace rack::device {
namespace no_allocation_test {

using namespace std::chrono_literals;

// Stores what one side has sent, in preallocated memory.
class StoredOutput final : public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    ASSERT_LT(count_, pieces_.size());
    ASSERT_LE(bytes.size(), pieces_[count_].bytes.size());
    std::ranges::copy(bytes, pieces_[count_].bytes.begin());
    pieces_[count_].size = bytes.size();
    pieces_[count_++].id = id;
  }
  // Passes everything to the other side.
  void pass(Dialogue& to, Time now, Output& answers) {
    const std::size_t count = std::exchange(count_, 0);
    for (std::size_t i = 0; i < count; ++i) {
      const Piece piece = pieces_[i];
      to.on_arrival({std::span(piece.bytes).first(piece.size), now, now, piece.id}, answers);
    }
  }
  [[nodiscard]] bool is_empty() const { return count_ == 0; }

 private:
  struct Piece {
    std::array<std::byte, 300> bytes{};
    std::size_t size = 0;
    std::uint32_t id = 0;
  };
  std::array<Piece, 64> pieces_{};
  std::size_t count_ = 0;
};

// Number of allocations of the driver's side in ten seconds; `command` is called every millisecond.
template <class Data, class Dialog, class Command>
std::size_t allocations_while(Dialog& host, Dialogue& device, Command command) {
  StoredOutput to_host;
  StoredOutput to_device;
  Time now{1000s};
  const Time ready_by = now + 10s;
  const Time end = ready_by + 10s;
  std::size_t count = 0;
  int data_sets = 0;
  device.start(now, to_host);
  host.start(now, to_device);
  Data data;
  Time recorded{};
  for (; now < end; now += 1ms) {
    if (device.next_timeout() <= now) device.on_timeout(now, to_host);
    to_device.pass(device, now, to_host);
    const std::size_t before = tims::test::allocations();
    to_host.pass(host, now, to_device);
    if (host.next_timeout() <= now) host.on_timeout(now, to_device);
    command(now);
    const bool has = host.take(data, recorded);
    if (now < ready_by) continue;
    count += tims::test::allocations() - before;
    data_sets += has ? 1 : 0;
  }
  EXPECT_FALSE(host.failure());
  EXPECT_GE(data_sets, 50);
  return count;
}

std::size_t allocations_of(ChassisDialogue& host, Dialogue& device) {
  return allocations_while<ChassisData>(host, device, [&](Time now) {
    const float speed = 100 + static_cast<float>((now - Time{}) / 50ms % 100);
    host.drive({.vx = speed, .omega = 0.1F}, now);
  });
}

TEST(NoAllocationTest, OnSerialLines) {
  P2os p2os({.sonar = true});
  PioneerEmulator pioneer;
  EXPECT_EQ(allocations_of(p2os, pioneer), 0U);
  for (const auto model : {RoombaModel::kRoomba, RoombaModel::kCreate2}) {
    Roomba roomba({.model = model});
    RoombaEmulator robot(model);
    EXPECT_EQ(allocations_of(roomba, robot), 0U);
  }
  Er1 er1({.ticks_per_mm = 20});
  Er1Emulator robot;
  EXPECT_EQ(allocations_of(er1, robot), 0U);
  MavlinkVehicle vehicle({.arms = true, .mode = RoverEmulator::kGuided});
  RoverEmulator rover;
  EXPECT_EQ(allocations_of(vehicle, rover), 0U);
}

using MakeMotor = std::function<std::unique_ptr<Motor>(std::uint8_t node, MotorTask task)>;
std::size_t allocations_at_can(Dialogue& bus, const Wheels& wheels, bool is_canopen,
                               const MakeMotor& make) {
  std::vector<MotorLink> links;
  for (std::size_t i = 0; i < wheels.motors(); ++i) {
    const auto task = wheels.is_steering(i) ? MotorTask::kPositions : MotorTask::kTurns;
    links.push_back({make(static_cast<std::uint8_t>(i + 1), task), "motor", 0.05});
  }
  MotorChassis chassis({.is_canopen = is_canopen}, wheels, std::move(links));
  return allocations_of(chassis, bus);
}

TEST(NoAllocationTest, OnCan) {
  const Wheels differential = Wheels::differential(400);
  const auto odrive = [](std::uint8_t node, MotorTask task) {
    return std::make_unique<Odrive>(node, task);
  };
  const auto vesc = [](std::uint8_t node, MotorTask task) {
    return std::make_unique<Vesc>(VescSettings{.node = node, .task = task});
  };
  const auto drive = [](std::uint8_t node, MotorTask task) {
    return std::make_unique<Cia402>(Cia402Settings{.node = node, .task = task});
  };
  EXPECT_EQ(allocations_at_can(*odrive_base(), differential, false, odrive), 0U);
  EXPECT_EQ(allocations_at_can(*vesc_base(), differential, false, vesc), 0U);
  EXPECT_EQ(allocations_at_can(*cia402_base(), differential, true, drive), 0U);
  EXPECT_EQ(allocations_at_can(*robucar(), Wheels::double_ackermann(1200, 1000, 0.5), true, drive),
            0U);
}

TEST(NoAllocationTest, AnAxis) {
  ServoAxis axis({.gear = 10, .min = -2, .max = 2});
  const auto bus = servo();
  EXPECT_EQ(allocations_while<ServoDriveData>(axis, *bus,
                                              [&](Time now) {
                                                if (!axis.is_ready()) return;
                                                const auto step = (now - Time{}) / 1ms;
                                                if (step % 40 == 0) axis.move(0.3, now);
                                                if (step % 700 == 0) axis.move_to(0, 0.5, 1);
                                                if (step % 5000 == 0) axis.home();
                                                (void)axis.is_reached();
                                              }),
            0U);
}

TEST(NoAllocationTest, CameraMounts) {
  for (const bool is_datagrams : {false, true}) {
    Visca mount({.is_datagrams = is_datagrams});
    emulator::PtzCamera camera(is_datagrams);
    const auto command = [&](Time now) {
      const auto step = (now - Time{}) / 1ms;
      if (step % 50 == 0) mount.move({.velPan = 0.1F, .velTilt = -0.1F, .velZoom = 2}, now);
      if (step % 700 == 0) mount.move_to({.posPan = 0.2F, .posZoom = 30});
      if (step % 5000 == 0) mount.home();
      (void)mount.take_reached();
    };
    EXPECT_EQ(allocations_while<PtzDriveData>(mount, camera, command), 0U) << is_datagrams;
  }
}

TEST(NoAllocationTest, BoardsWithPins) {
  Firmata board({.layout = {.inputs = {2, 3}, .outputs = {12, 13}, .analogs = {0}}});
  emulator::IoBoard pins;
  const auto command = [&](Time now) {
    const std::array<u8, 2> levels{static_cast<u8>((now - Time{}) / 30ms % 2), 1};
    board.set(levels);
  };
  EXPECT_EQ(allocations_while<IoData>(board, pins, command), 0U);
}

}  // namespace no_allocation_test
}  // namespace rack::device
