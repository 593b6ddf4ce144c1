#include "components/pilot/pilot_replay.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace rack::pilot {
namespace {

using device::CaptureRecord;
using tims::Errc;
using tims::Error;

template <typename T>
Result<T> read(const CaptureRecord& record) {
  auto value = decode<T>(record.bytes, std::endian::little);
  if (!value) return Error(Errc::kMalformed, value.error().detail());
  return value;
}

template <typename T>
bool same_bits(const T& a, const T& b) {
  std::array<std::byte, body_max<T>()> of_a{};
  std::array<std::byte, body_max<T>()> of_b{};
  return encode(a, of_a) && encode(b, of_b) && of_a == of_b;
}

std::string to_text(const ChassisMoveData& move) {
  const auto omega = static_cast<float>(move.omega);
  return fmt::format("MOVE {} mm/s, {} rad/s ({:08x})", move.vx.raw(), omega,
                     std::bit_cast<std::uint32_t>(omega));
}

std::string to_text(const PilotStatusData& status) {
  return fmt::format("state {}, {} mm to go, at {} {} mm", status.pilotState,
                     status.distanceToDest.raw(), status.pos.x.raw(), status.pos.y.raw());
}

}  // namespace

// --- other parameters

std::span<const PilotReplay::Changeable> PilotReplay::all_changeable() {
  static constexpr std::array<Changeable, 5> kAll = {{
      {"maxSpeed", &Changes::max_speed},
      {"lag", &Changes::lag},
      {"steeringRate", &Changes::steering_rate},
      {"deviationMax", &Changes::deviation_max},
      {"replanTime", &Changes::replan_time},
  }};
  return kAll;
}

std::string PilotReplay::changeable() {
  std::string names;
  for (const Changeable& one : all_changeable()) {
    if (!names.empty()) names += ", ";
    names += one.name;
  }
  return names;
}

Result<void> PilotReplay::change(std::string_view name, i32 value) {
  for (const Changeable& one : all_changeable()) {
    if (one.name != name) continue;
    changes_.*one.value = value;
    return {};
  }
  return Error(Errc::kInvalidArgument,
               fmt::format("\"{}\" cannot be changed; choose one of {}", name, changeable()));
}

// --- records

Result<void> PilotReplay::take(const CaptureRecord& record) {
  if (record.direction == device::Direction::kEvent) return {};
  const auto kind = static_cast<PilotRecord>(record.id);
  if (kind < PilotRecord::kBegin || kind > PilotRecord::kLast)
    return Error(Errc::kMalformed, fmt::format("{:08X} is not a record of a pilot", record.id));
  if (kind == PilotRecord::kBegin) return begin(record);
  if (is_lost_) {
    undecided_ += kind == PilotRecord::kCycle ? 1 : 0;
    return {};
  }
  if (kind == PilotRecord::kCycle) return cycle(record);
  ++records_;
  if (kind == PilotRecord::kMove) return compare_move(record);
  if (kind == PilotRecord::kStatus) return compare_status(record);
  return kind < PilotRecord::kCycle ? take_input(record) : take_command(record);
}

Result<void> PilotReplay::begin(const CaptureRecord& record) {
  auto settings = read<PathDriverSettings>(record);
  if (!settings) return settings.error();
  settings->maxSpeed = changes_.max_speed.value_or(settings->maxSpeed);
  settings->lag = changes_.lag.value_or(settings->lag);
  settings->steeringRate = changes_.steering_rate.value_or(settings->steeringRate);
  if (auto good = driver_.begin(*settings); !good) return good;
  ++begins_;
  records_ = 1;
  is_lost_ = false;
  why_.reset();
  return {};
}

Result<void> PilotReplay::take_input(const CaptureRecord& record) {
  PathDriver::Inputs& inputs = driver_.inputs();
  const auto into = [&](auto& data) -> Result<void> {
    auto good = decode(record.bytes, std::endian::little, data);
    if (good) return good;
    is_lost_ = true;
    return Error(Errc::kMalformed, good.error().detail());
  };
  switch (static_cast<PilotRecord>(record.id)) {
    case PilotRecord::kPosition:
      return into(inputs.position);
    case PilotRecord::kChassis:
      return into(inputs.chassis);
    case PilotRecord::kPath:
      return into(inputs.path);
    default:
      return into(inputs.scan);
  }
}

Result<void> PilotReplay::take_command(const CaptureRecord& record) {
  const auto with = [&]<typename T>(const Result<T>& message, auto what) -> Result<void> {
    if (!message) return message.error();
    what(*message);
    return {};
  };
  switch (static_cast<PilotRecord>(record.id)) {
    case PilotRecord::kHold:
      return with(read<PilotHoldData>(record), [&](const auto& message) { driver_.hold(message); });
    case PilotRecord::kRevert:
      return with(read<PilotRevertData>(record),
                  [&](const auto& message) { driver_.revert(message); });
    case PilotRecord::kWatchdog:
      return with(read<PilotWatchdogData>(record),
                  [&](const auto& message) { driver_.watch(message); });
    case PilotRecord::kPlan:
      return with(read<PilotPlan>(record), [&](const auto& plan) { driver_.plan(plan.state); });
    default:
      return with(read<PilotMultiDestData>(record),
                  [&](const auto& further) { driver_.keep(further.points); });
  }
}

Result<void> PilotReplay::cycle(const CaptureRecord& record) {
  auto recorded = read<RecordedCycle>(record);
  if (!recorded) return recorded.error();
  if (recorded->records != records_) {
    is_lost_ = true;
    ++undecided_;
    return {};
  }
  ++records_;
  cycle_ = recorded->cycle;
  cycle_.deviationMax = changes_.deviation_max.value_or(cycle_.deviationMax);
  cycle_.replanTime = changes_.replan_time.value_or(cycle_.replanTime);
  move_ = driver_.step(cycle_);
  status_ = driver_.status();
  note_why(record.time);
  (void)driver_.take_request();  // its answer, if any, is in the recording
  ++decisions_;
  has_differed_ = false;
  return {};
}

// --- differences

Result<void> PilotReplay::compare_move(const CaptureRecord& record) {
  const auto then = read<ChassisMoveData>(record);
  if (!then) return then.error();
  if (!same_bits(*then, move_))
    differs(record, to_text(*then) + " recorded, " + to_text(move_) + " in the replay");
  return {};
}

Result<void> PilotReplay::compare_status(const CaptureRecord& record) {
  const auto then = read<PilotStatusData>(record);
  if (!then) return then.error();
  if (!same_bits(*then, status_))
    differs(record, to_text(*then) + " recorded, " + to_text(status_) + " in the replay");
  return {};
}

void PilotReplay::differs(const CaptureRecord& record, const std::string& what) {
  if (!has_differed_) ++different_;
  has_differed_ = true;
  if (!first_) first_ = {.at = record.time, .text = what + "; by " + inputs()};
}

std::string PilotReplay::inputs() const {
  const PathDriver::Inputs& by = driver_.inputs();
  return fmt::format(
      "position {} {} mm {:.4f} rad ({} ms old), {} mm/s, {} points of a scan ({} ms old), {} "
      "splines: {}",
      by.position.pos.x.raw(), by.position.pos.y.raw(), static_cast<float>(by.position.pos.rho),
      (cycle_.time - by.position.recordingTime).count(), static_cast<float>(by.chassis.vx),
      by.scan.points.size(), (cycle_.time - by.scan.recordingTime).count(), by.path.splines.size(),
      driver_.why_text());
}

void PilotReplay::note_why(tims::Duration at) {
  const bool stops = move_.vx == 0;
  if (why_ == driver_.why() && stops == events_.back().stops) return;
  why_ = driver_.why();
  events_.push_back({at, Pose::of(status_.pos), stops, driver_.why_text()});
}

}  // namespace rack::pilot
