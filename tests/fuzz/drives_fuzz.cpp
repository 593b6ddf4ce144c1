// Bytes and frames to the dialogues with chassis, axes, camera mounts and boards, in pieces of any
// size, while they are commanded to move: none of them fails, and their data are finite.
#include <cmath>
#include <memory>

#include "components/devices/camera/visca.h"
#include "components/devices/chassis/er1.h"
#include "components/devices/chassis/mavlink_vehicle.h"
#include "components/devices/chassis/motor_chassis.h"
#include "components/devices/chassis/odrive.h"
#include "components/devices/chassis/p2os.h"
#include "components/devices/chassis/roomba.h"
#include "components/devices/chassis/servo_axis.h"
#include "components/devices/chassis/vesc.h"
#include "components/devices/pins/firmata.h"
#include "tests/fuzz/finite.h"

namespace {

using namespace rack::device;
using tims::fuzz::require;
using namespace std::chrono_literals;

constexpr std::size_t kFrameMax = 8;

// Checks that every frame sent is complete.
struct Bus : Output {
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    require(bytes.size() <= kFrameMax);
    require((id & can::kExtended) != 0 || (id & ~can::kRemote) <= 0x7FF);
  }
};
struct Line : Output {
  void send(std::span<const std::byte> bytes, std::uint32_t) override { require(!bytes.empty()); }
};

template <class Data>
void check(const Data& data) {
  tims::fuzz::require_finite(data);
  if constexpr (std::same_as<Data, rack::IoData>) require(data.values.size() == 5);
}

// Data of an autopilot in addition to those of a vehicle.
template <class Dialog>
void check_others(Dialog&) {}
template <>
void check_others(MavlinkVehicle& vehicle) {
  Time recorded;
  if (rack::GpsData gps; vehicle.take_gps(gps, recorded)) check(gps);
  if (rack::GyroData gyro; vehicle.take_gyro(gyro, recorded)) check(gyro);
  if (rack::PositionData position; vehicle.take_position(position, recorded)) check(position);
}

void command(ChassisDialogue& chassis, int step, Time now) {
  chassis.drive({.vx = 10.0F * static_cast<float>(step % 7 - 3), .omega = 0.1F}, now);
}
void command(ServoAxis& axis, int step, Time now) {
  if (step % 5 == 0) axis.move(0.1 * (step % 3 - 1), now);
  if (step % 5 == 2) axis.move_to(0.01 * step, 0.5, 0);
  if (step % 50 == 3) axis.home();
}
void command(Visca& mount, int step, Time now) {
  if (step % 5 == 0) mount.move({.velPan = 0.1F, .velTilt = -0.1F, .velZoom = 3}, now);
  if (step % 5 == 2) mount.move_to({.posPan = 0.2F, .posZoom = 20});
  if (step % 50 == 3) mount.home();
  (void)mount.take_reached();
}
void command(Firmata& board, int step, Time) {
  const std::array<rack::u8, 2> levels{static_cast<rack::u8>(step % 2), 1};
  board.set(levels);
}

// `next` returns the next bytes; empty: the end.
template <class Data, class Dialog, class Next>
void talk(Dialog& dialogue, Output& out, Next next) {
  Time now(1s);
  Data data;
  Time recorded;
  dialogue.start(now, out);
  for (int step = 0;; ++step) {
    const std::optional<Arrival> arrival = next(now);
    if (!arrival) break;
    dialogue.on_arrival(*arrival, out);
    command(dialogue, step, now);
    if (dialogue.next_timeout() <= now) dialogue.on_timeout(now, out);
    if (dialogue.take(data, recorded)) check(data);
    check_others(dialogue);
    if (dialogue.failure()) dialogue.start(now, out);
  }
  dialogue.stop(now, out);
}

template <class Data, class Dialog>
void talk_at_line(Dialog dialogue, tims::fuzz::Input input) {
  Line line;
  const std::size_t piece = std::size_t{input.number<std::uint8_t>()} + 1;
  auto rest = input.rest();
  talk<Data>(dialogue, line, [&](Time& now) -> std::optional<Arrival> {
    if (rest.empty()) return {};
    const auto part = rest.first(std::min(piece, rest.size()));
    rest = rest.subspan(part.size());
    now += 5ms;
    return Arrival{.bytes = part, .first = now, .last = now};
  });
}

// Format of a frame: time since the last one (ms), identifier (4 bytes), size, bytes.
template <class Data, class Dialog>
void talk_at_bus(Dialog dialogue, tims::fuzz::Input input) {
  Bus bus;
  talk<Data>(dialogue, bus, [&](Time& now) -> std::optional<Arrival> {
    if (input.empty()) return {};
    now += std::chrono::milliseconds(input.number<std::uint8_t>());
    const auto id = input.number<std::uint32_t>();
    const std::size_t size = input.number<std::uint8_t>() % (kFrameMax + 1);
    return Arrival{.bytes = std::as_bytes(input.take(size)), .first = now, .last = now, .id = id};
  });
}

// Two motors, or two per axle, with node numbers 1, 2, and so on.
template <class Make>
MotorChassis vehicle(const Wheels& wheels, bool is_canopen, Make make) {
  std::vector<MotorLink> links;
  for (std::size_t i = 0; i < wheels.motors(); ++i)
    links.push_back(
        {.motor = make(static_cast<std::uint8_t>(i + 1),
                       wheels.is_steering(i) ? MotorTask::kPositions : MotorTask::kTurns),
         .name = "motor",
         .gear = 0.05});
  return {{.is_canopen = is_canopen}, wheels, std::move(links)};
}

void talk_with_motors(int which, tims::fuzz::Input input) {
  const Wheels two = Wheels::differential(400);
  const Wheels six = Wheels::double_ackermann(1200, 1000, 0.5);
  const Wheels& wheels = which >= 3 ? six : two;
  if (which % 3 == 0)
    talk_at_bus<rack::ChassisData>(vehicle(wheels, false,
                                           [](std::uint8_t node, MotorTask task) {
                                             return std::make_unique<Odrive>(node, task);
                                           }),
                                   input);
  else if (which % 3 == 1)
    talk_at_bus<rack::ChassisData>(
        vehicle(wheels, false,
                [](std::uint8_t node, MotorTask task) {
                  return std::make_unique<Vesc>(VescSettings{.node = node, .task = task});
                }),
        input);
  else
    talk_at_bus<rack::ChassisData>(
        vehicle(wheels, true,
                [](std::uint8_t node, MotorTask task) {
                  return std::make_unique<Cia402>(Cia402Settings{.node = node, .task = task});
                }),
        input);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tims::fuzz::Input input(data, size);
  switch (const int what = input.number<std::uint8_t>() % 16; what) {
    case 0:
      talk_at_line<rack::ChassisData>(P2os({.sonar = true}), input);
      break;
    case 1:
      talk_at_line<rack::ChassisData>(Roomba({.model = RoombaModel::kRoomba}), input);
      break;
    case 2:
      talk_at_line<rack::ChassisData>(Roomba({.model = RoombaModel::kCreate2}), input);
      break;
    case 3:
      talk_at_line<rack::ChassisData>(Er1({.ticks_per_mm = 20}), input);
      break;
    case 4:
      talk_at_line<rack::ChassisData>(MavlinkVehicle({.arms = true, .mode = 15}), input);
      break;
    case 5:
      talk_at_line<rack::PtzDriveData>(Visca({}), input);
      break;
    case 6:
      talk_at_line<rack::PtzDriveData>(Visca({.is_datagrams = true}), input);
      break;
    case 7:
      talk_at_line<rack::IoData>(
          Firmata({.layout = {.inputs = {2, 3}, .outputs = {12, 13}, .analogs = {0}}}), input);
      break;
    case 8:
      talk_at_bus<rack::ServoDriveData>(ServoAxis({.gear = 10, .min = -2, .max = 2}), input);
      break;
    case 9:
      talk_at_line<rack::ChassisData>(P2os({.only_listen = true}), input);
      break;
    default:
      talk_with_motors(what - 10, input);
      break;
  }
  return 0;
}
