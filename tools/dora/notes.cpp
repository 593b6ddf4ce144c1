#include "tools/dora/notes.h"

#include <algorithm>
#include <cmath>

#include "rack/codec/codec.h"

namespace rack::dora {
namespace {

constexpr std::size_t kRoom = 1 << 16;

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
}

void Notes::take(std::size_t stream, const tims::MessageView& message, Time at) {
  const std::lock_guard lock(mutex_);
  last_.at(stream) = at;
  if (counts_) spans_.at(stream).back().push_back(at);
  const std::string_view component = kStreams.at(stream).component;
  if (component == "Pilot(1/0)" && decode(message, pilot_))
    pilots_.push_back({at, pilot_.speed, pilot_.pilotState});
  if (component == "Position(1/0)")
    if (const auto position = decode<PositionData>(message)) positions_.push_back(*position);
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
  return positions_.empty() ? PositionData{} : positions_.back();
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

std::vector<PositionData> Notes::positions() const {
  const std::lock_guard lock(mutex_);
  return positions_;
}

}  // namespace rack::dora
