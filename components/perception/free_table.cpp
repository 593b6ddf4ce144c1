#include "components/perception/free_table.h"

#include <algorithm>
#include <cmath>

namespace rack::perception {
namespace {

constexpr double kBeyond = 200;       // mm: minimum by which a beam goes beyond a place
constexpr double kBeyondPart = 0.03;  // plus this share of the distance to it
constexpr double kSamePlace = 150;    // mm

}  // namespace

// The direction, 0 to 4 around the turn, as an index of the table.
std::size_t FreeTable::direction(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  const double part = sum > 0 ? y / sum : 0;
  const double around = x < 0 ? 2 - part : (y < 0 ? 4 + part : part);
  return static_cast<std::size_t>(around * (kDirections / 4.0)) % kDirections;
}

// Sets the directions within a part of the beam's width; where several beams overlap, the shortest
// wins.
void FreeTable::mark(Table& table, double x, double y, double half, float away) {
  const std::size_t to = direction(x - half * y, y + half * x);
  for (std::size_t at = direction(x + half * y, y - half * x);; at = (at + 1) % kDirections) {
    table[at] = table[at] == 0 ? away : std::min(table[at], away);
    if (at == to) break;
  }
}

void FreeTable::fill(const ScanView& scan) {
  from_ = {scan.scanner().x, scan.scanner().y};
  spread_ = std::tan(scan.resolution());
  free_.fill(0);
  met_.fill(0);
  // Its own width and that of its neighbours.
  const double around = std::tan(1.5 * scan.resolution());
  const double within = std::tan(0.5 * scan.resolution());
  for (const Sight& sight : scan.sights()) {
    const double dx = sight.x - from_.x;
    const double dy = sight.y - from_.y;
    const auto away = static_cast<float>(sight.away);
    mark(free_, dx, dy, around, away);
    if (sight.hit) mark(met_, dx, dy, within, away);
  }
}

FreeTable::Distances FreeTable::at(std::size_t direction) const {
  return {.free = static_cast<double>(free_[direction]),
          .met = static_cast<double>(met_[direction])};
}

FreeTable::Distances FreeTable::towards(double dx, double dy) const {
  return at(direction(dx, dy));
}

bool FreeTable::is_through(const Distances& distances, double away) {
  return distances.free > away * (1 + kBeyondPart) + kBeyond;
}

bool FreeTable::is_met(const Distances& distances, double away) {
  return distances.met > 0 && std::abs(distances.met - away) < kSamePlace;
}

FreeTable::Seen FreeTable::look(const MapPoint& at, double half) const {
  const double dx = at.x - from_.x;
  const double dy = at.y - from_.y;
  const double away = std::hypot(dx, dy);
  const double part = std::clamp(half / std::max(away, 1.0), spread_, 1.0);
  const std::size_t to = direction(dx - part * dy, dy + part * dx);
  bool through = true;
  for (std::size_t i = direction(dx + part * dy, dy - part * dx);; i = (i + 1) % kDirections) {
    const Distances distances = this->at(i);
    if (is_met(distances, away)) return Seen::kMet;
    through = through && is_through(distances, away);
    if (i == to) break;
  }
  return through ? Seen::kThrough : Seen::kHidden;
}

}  // namespace rack::perception
