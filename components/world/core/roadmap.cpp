#include "components/world/core/roadmap.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

namespace rack::world {

namespace {

constexpr int kThrows = 6000;
constexpr double kRoomMax = 400;  // mm: maximum distance of a person from the line
constexpr double kLongestLeg = 30000;

// The room beside the line, negative if a person does not fit. Steps are as long as the clearance
// of a point allows.
double room_along(const Scenery& scenery, const MapPoint& from, const MapPoint& to, double radius) {
  const double length = distance(from, to);
  double room = kRoomMax;
  for (double along = 0;;) {
    const double part = length > 0 ? along / length : 0;
    const MapPoint at{from.x + part * (to.x - from.x), from.y + part * (to.y - from.y)};
    const double clearance = scenery.clearance(at, radius + kRoomMax);
    room = std::min(room, clearance - radius);
    if (room < 0 || along >= length) return room;
    constexpr double kStepMin = 10;
    along = std::min(length, along + std::max(kStepMin, clearance - radius - room / 2));
  }
}

}  // namespace

Roadmap::Roadmap(const Scenery& scenery, const Area& area, double radius, std::uint64_t seed,
                 std::span<const MapPoint> wanted) {
  Random random(seed);
  for (const MapPoint& at : wanted)
    if (places_.size() < kPlacesMax && !find(at) && scenery.clearance(at, radius) >= radius)
      places_.push_back(at);
  throw_places(scenery, area, radius, random);
  Links links = joined(scenery, radius);
  keep_largest(links);
  find_paths(links);
  links_ = std::move(links);
}

// First samples places with a minimum distance; then fills the remaining room.
void Roadmap::throw_places(const Scenery& scenery, const Area& area, double radius,
                           Random& random) {
  const double height = area.to.x - area.from.x;
  const double width = area.to.y - area.from.y;
  double apart = std::sqrt(height * width / static_cast<double>(kPlacesMax));
  for (int i = 0; i < kThrows && places_.size() < kPlacesMax; ++i) {
    if (i % (kThrows / 4) == 0 && i > 0) apart /= 2;
    const MapPoint at{area.from.x + height * static_cast<double>(random.uniform()),
                      area.from.y + width * static_cast<double>(random.uniform())};
    if (scenery.clearance(at, radius) < radius) continue;
    const auto is_near = [&](const MapPoint& other) { return distance(at, other) < apart; };
    if (std::ranges::none_of(places_, is_near)) places_.push_back(at);
  }
}

Roadmap::Links Roadmap::joined(const Scenery& scenery, double radius) const {
  Links links(places_.size());
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t from = 0; from < places_.size(); ++from) {
    near.clear();
    for (std::size_t to = 0; to < places_.size(); ++to) {
      const double length = distance(places_[from], places_[to]);
      if (to != from && length < kLongestLeg) near.emplace_back(length, to);
    }
    std::ranges::sort(near);
    for (const auto& [length, to] : near) {
      if (links[from].size() >= kLinksMax) break;
      if (to < from && std::ranges::any_of(links[to], [&](const Link& l) { return l.to == from; }))
        continue;
      const double room = room_along(scenery, places_[from], places_[to], radius);
      if (room < 0) continue;
      links[from].push_back({to, length, room});
      links[to].push_back({from, length, room});
    }
  }
  return links;
}

void Roadmap::keep_largest(Links& links) {
  constexpr std::size_t kNone = kPlacesMax;
  std::vector<std::size_t> part(places_.size(), kNone);
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (part[i] != kNone) continue;
    std::vector<std::size_t> open = {i};
    part[i] = sizes.size();
    sizes.push_back(0);
    while (!open.empty()) {
      const std::size_t at = open.back();
      open.pop_back();
      ++sizes.back();
      for (const Link& link : links[at]) {
        if (part[link.to] == kNone) {
          part[link.to] = part[at];
          open.push_back(link.to);
        }
      }
    }
  }
  if (sizes.empty()) return;
  const auto largest = static_cast<std::size_t>(std::ranges::max_element(sizes) - sizes.begin());
  std::vector<std::size_t> number(places_.size(), kNone);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (part[i] != largest) continue;
    number[i] = kept;
    places_[kept] = places_[i];
    if (kept != i) links[kept] = std::move(links[i]);
    ++kept;
  }
  places_.resize(kept);
  links.resize(kept);
  for (auto& of_place : links)
    for (Link& link : of_place) link.to = number[link.to];
}

void Roadmap::find_paths(const Links& links) {
  next_.assign(size() * size(), 0);
  using Open = std::pair<double, std::size_t>;
  for (std::size_t goal = 0; goal < size(); ++goal) {
    std::vector<double> shortest(size(), kNoHit);
    std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
    shortest[goal] = 0;
    next_[goal * size() + goal] = static_cast<std::uint16_t>(goal);
    open.emplace(0, goal);
    while (!open.empty()) {
      const auto [length, at] = open.top();
      open.pop();
      if (length > shortest[at]) continue;
      for (const Link& link : links[at]) {
        if (length + link.length >= shortest[link.to]) continue;
        shortest[link.to] = length + link.length;
        next_[goal * size() + link.to] = static_cast<std::uint16_t>(at);
        open.emplace(shortest[link.to], link.to);
      }
    }
  }
}

std::optional<std::size_t> Roadmap::find(const MapPoint& wanted) const {
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (places_[i].x == wanted.x && places_[i].y == wanted.y) return i;
  return std::nullopt;
}

double Roadmap::room(std::size_t from, std::size_t to) const {
  for (const Link& link : links_[from])
    if (link.to == to) return link.room;
  return 0;
}

}  // namespace rack::world
