// Drivers of chassis take no memory while they drive.
#include <gtest/gtest.h>

#include "devices/emulators/er1_robot.h"
#include "devices/emulators/motor_bus.h"
#include "devices/emulators/pioneer.h"
#include "devices/emulators/roomba_robot.h"
#include "devices/emulators/rover.h"
#include "devices/protocol/mavlink_vehicle.h"
#include "devices/protocol/motor_chassis.h"
#include "tests/support/counted_new.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

// What one side has said, in memory that is there already.
class Said final : public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    ASSERT_LT(count_, pieces_.size());
    ASSERT_LE(bytes.size(), pieces_[count_].bytes.size());
    std::ranges::copy(bytes, pieces_[count_].bytes.begin());
    pieces_[count_].size = bytes.size();
    pieces_[count_++].id = id;
  }
  // Hands all of it over.
  void tell(Dialogue& to, Time now, Output& answers) {
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

// Of the driver's side, in ten seconds of driving.
std::size_t allocations_of(ChassisDialogue& host, Dialogue& device) {
  Said to_host;
  Said to_device;
  Time now{1000s};
  const Time ready_by = now + 10s;
  const Time end = ready_by + 10s;
  std::size_t count = 0;
  int data_sets = 0;
  device.start(now, to_host);
  host.start(now, to_device);
  ChassisData data;
  Time recorded{};
  for (; now < end; now += 1ms) {
    if (device.next_timeout() <= now) device.on_timeout(now, to_host);
    to_device.tell(device, now, to_host);
    const std::size_t before = tims::test::allocations();
    to_host.tell(host, now, to_device);
    if (host.next_timeout() <= now) host.on_timeout(now, to_device);
    const float speed = 100 + static_cast<float>((now - Time{}) / 50ms % 100);
    host.drive({.vx = speed, .omega = 0.1F}, now);
    const bool has = host.take(data, recorded);
    if (now < ready_by) continue;
    count += tims::test::allocations() - before;
    data_sets += has ? 1 : 0;
  }
  EXPECT_FALSE(host.failure());
  EXPECT_GE(data_sets, 50);
  return count;
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

std::size_t allocations_at_can(Dialogue& bus, bool is_canopen,
                               const std::function<std::unique_ptr<Motor>(std::uint8_t)>& make) {
  std::vector<MotorLink> links;
  for (std::uint8_t node = 1; node <= 2; ++node) links.push_back({make(node), "motor", 0.05});
  MotorChassis chassis({.is_canopen = is_canopen}, Wheels::differential(400), std::move(links));
  return allocations_of(chassis, bus);
}

TEST(NoAllocationTest, OnCan) {
  EXPECT_EQ(allocations_at_can(*odrive_base(), false,
                               [](std::uint8_t node) {
                                 return std::make_unique<Odrive>(node, MotorTask::kTurns);
                               }),
            0U);
  EXPECT_EQ(allocations_at_can(*vesc_base(), false,
                               [](std::uint8_t node) {
                                 return std::make_unique<Vesc>(VescSettings{.node = node});
                               }),
            0U);
  EXPECT_EQ(allocations_at_can(*cia402_base(), true,
                               [](std::uint8_t node) {
                                 return std::make_unique<Cia402>(Cia402Settings{.node = node});
                               }),
            0U);
}

}  // namespace
}  // namespace rack::device
