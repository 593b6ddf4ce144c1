#include "tools/evaluation/dora/notes.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "rack/codec/codec.h"

namespace rack::dora {
namespace {

constexpr std::size_t kRoom = 1 << 16;
constexpr std::string_view kRobot = "dora";  // its name in the world file

}  // namespace

std::size_t stream_of(std::string_view component) {
  const auto* const found = std::ranges::find(kStreams, component, &Stream::component);
  return static_cast<std::size_t>(found - kStreams.begin());
}

Notes::Notes() {
  pilots_.reserve(kRoom);
  scans_.reserve(kRoom);
  positions_.reserve(kRoom);
  reserve_all(scan_);
  reserve_all(pilot_);
  reserve_all(path_);
  reserve_all(world_);
  truths_.reserve(kRoom);
}

void Notes::take(std::size_t stream, const tims::MessageView& message, Time at) {
  const std::lock_guard lock(mutex_);
  const std::string_view component = kStreams.at(stream).component;
  if (message.header.type != tims::type::kData) {
    // The pilot has stopped its chassis before it reports the error.
    if (component == "Pilot(1/0)") pilots_.push_back({at, 0, pilot_state::kPathError});
    return;
  }
  last_.at(stream) = at;
  if (counts_) spans_.at(stream).back().push_back(at);
  if (component == "Pilot(1/0)" && decode(message, pilot_))
    pilots_.push_back({at, pilot_.speed, pilot_.pilotState});
  if (component == "Position(1/0)")
    if (const auto position = decode<PositionData>(message)) positions_.push_back({at, *position});
  if (component == "World(1/0)") take_truth(message, at);
  if (component == "Path(1/0)") (void)decode(message, path_);
  if (component == "Scan2d(1/0)" && region_radius_ > 0) take_scan(message, at);
}

void Notes::take_scan(const tims::MessageView& message, Time at) {
  if (!decode(message, scan_)) return;
  const auto is_there = [&](const ScanPoint& point) {
    return (point.type & scan_point::kInvalid) == 0 &&
           std::hypot(point.x - region_x_, point.y - region_y_) <= region_radius_;
  };
  scans_.push_back({at, scan_.recordingTime, std::ranges::any_of(scan_.points, is_there)});
}

void Notes::begin_span() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(counts_, true)) return;
  for (auto& spans : spans_) spans.emplace_back().reserve(kRoom);
}

void Notes::end_span() {
  const std::lock_guard lock(mutex_);
  counts_ = false;
}

bool Notes::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::vector<std::vector<Time>> Notes::spans(std::size_t stream) const {
  const std::lock_guard lock(mutex_);
  return spans_.at(stream);
}

std::optional<Time> Notes::last(std::size_t stream) const {
  const std::lock_guard lock(mutex_);
  return last_.at(stream);
}

std::optional<PilotNote> Notes::pilot(Time after,
                                      const std::function<bool(const PilotNote&)>& so) const {
  const std::lock_guard lock(mutex_);
  for (const PilotNote& note : pilots_)
    if (note.at >= after && so(note)) return note;
  return {};
}

std::optional<PilotNote> Notes::newest_pilot() const {
  const std::lock_guard lock(mutex_);
  if (pilots_.empty()) return {};
  return pilots_.back();
}

PositionData Notes::position() const {
  const std::lock_guard lock(mutex_);
  return positions_.empty() ? PositionData{} : positions_.back().data;
}

PathData Notes::path() const {
  const std::lock_guard lock(mutex_);
  return path_;
}

void Notes::look_at(double x, double y, double radius) {
  const std::lock_guard lock(mutex_);
  scans_.clear();
  region_x_ = x;
  region_y_ = y;
  region_radius_ = radius;
}

std::optional<ScanNote> Notes::seen(TimeStamp after) const {
  const std::lock_guard lock(mutex_);
  for (const ScanNote& note : scans_)
    if (note.recorded - after >= std::chrono::milliseconds(0) && note.in_region) return note;
  return {};
}

// --- the truth

void Notes::take_truth(const tims::MessageView& message, Time at) {
  if (!decode(message, world_)) return;
  const WorldThing* const dora = world_.find(world_thing::kRobot, kRobot);
  if (dora == nullptr) return;
  truths_.push_back({.at = at,
                     .recorded = world_.recordingTime,
                     .pose = {.x = static_cast<double>(dora->pos.x),
                              .y = static_cast<double>(dora->pos.y),
                              .rho = static_cast<double>(dora->pos.rho)},
                     .speed = static_cast<double>(dora->vx),
                     .travelled = static_cast<double>(dora->travelled),
                     .posts = dora->obstacles,
                     .walls = dora->walls,
                     .people = dora->people});
}

TruthNote Notes::truth() const {
  const std::lock_guard lock(mutex_);
  return truths_.empty() ? TruthNote{} : truths_.back();
}

std::vector<TruthNote> Notes::truths(Time since) const {
  const std::lock_guard lock(mutex_);
  const auto first = std::ranges::lower_bound(truths_, since, {}, &TruthNote::at);
  return {first, truths_.end()};
}

// Interpolates between two states that are at most kApart apart.
std::optional<TruthNote> Notes::truth_of(TimeStamp time) const {
  constexpr std::chrono::milliseconds kApart(200);
  const auto after =
      std::ranges::lower_bound(truths_, std::chrono::milliseconds(0), {},
                               [&](const TruthNote& note) { return note.recorded - time; });
  if (after == truths_.begin() || after == truths_.end()) return {};
  const TruthNote& before = *std::prev(after);
  const auto apart = after->recorded - before.recorded;
  if (apart > kApart || apart.count() == 0) return {};
  const double part = std::chrono::duration<double>(time - before.recorded) / apart;
  TruthNote truth = before;
  truth.pose = between(before.pose, after->pose, part);
  return truth;
}

double PositionNote::error() const {
  return std::hypot(pose.x - truth.pose.x, pose.y - truth.pose.y);
}

std::vector<PositionNote> Notes::positions(Time since) const {
  const std::lock_guard lock(mutex_);
  std::vector<PositionNote> notes;
  for (const Believed& believed : positions_) {
    if (believed.at < since) continue;
    if (const auto truth = truth_of(believed.data.recordingTime))
      notes.push_back({believed.at, Pose::of(believed.data.pos), *truth});
  }
  return notes;
}

std::vector<double> Notes::position_errors(Time since) const {
  std::vector<double> errors;
  for (const PositionNote& note : positions(since)) errors.push_back(note.error());
  return errors;
}

}  // namespace rack::dora
