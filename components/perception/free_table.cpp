#include "components/perception/free_table.h"

#include <algorithm>
#include <cmath>

namespace rack::perception {
namespace {

constexpr double kBeyond = 200;       // mm that a beam went beyond a place, at least
constexpr double kBeyondPart = 0.03;  // and of the way to it
constexpr double kSamePlace = 150;    // mm

}  // namespace

// 0 to 4 around the turn, as a place in the table.
std::size_t FreeTable::direction(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  const double part = sum > 0 ? y / sum : 0;
  const double around = x < 0 ? 2 - part : (y < 0 ? 4 + part : part);
  return static_cast<std::size_t>(around * (kDirections / 4.0)) % kDirections;
}

// A beam says it for what lies within a part of its width; where several say something, the
// shortest counts.
void FreeTable::say(Table& table, double x, double y, double half, float away) {
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
    say(free_, dx, dy, around, away);
    if (sight.hit) say(met_, dx, dy, within, away);
  }
}

FreeTable::Ways FreeTable::at(std::size_t direction) const {
  return {.free = static_cast<double>(free_[direction]),
          .met = static_cast<double>(met_[direction])};
}

FreeTable::Ways FreeTable::towards(double dx, double dy) const { return at(direction(dx, dy)); }

bool FreeTable::is_through(const Ways& ways, double away) {
  return ways.free > away * (1 + kBeyondPart) + kBeyond;
}

bool FreeTable::is_met(const Ways& ways, double away) {
  return ways.met > 0 && std::abs(ways.met - away) < kSamePlace;
}

FreeTable::Seen FreeTable::look(const MapPoint& at, double half) const {
  const double dx = at.x - from_.x;
  const double dy = at.y - from_.y;
  const double away = std::hypot(dx, dy);
  const double part = std::clamp(half / std::max(away, 1.0), spread_, 1.0);
  const std::size_t to = direction(dx - part * dy, dy + part * dx);
  bool through = true;
  for (std::size_t i = direction(dx + part * dy, dy - part * dx);; i = (i + 1) % kDirections) {
    const Ways ways = this->at(i);
    if (is_met(ways, away)) return Seen::kMet;
    through = through && is_through(ways, away);
    if (i == to) break;
  }
  return through ? Seen::kThrough : Seen::kHidden;
}

}  // namespace rack::perception
