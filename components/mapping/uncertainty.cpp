#include "components/mapping/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace rack::mapping {

namespace {

constexpr double kStationEvery = 1000;   // mm
constexpr double kLoopWay = 500;         // mm that a loop counts for
constexpr double kTurnWay = 300;         // mm for a turn of a radian
constexpr double kUnmatchedWay = 15000;  // mm for a keyframe placed by odometry alone
constexpr double kSearchedWay = 3000;    // mm for one that was searched
// What was found in logs of five buildings. Near: noise prevails, far: drift.
constexpr double kWindowLeast = 300;  // mm
constexpr double kWindowMost = 40000;
constexpr double kNearByWay = 0.05;
constexpr double kFarLeast = 1000;  // mm
constexpr double kFarByWay = 0.015;
constexpr double kTurnLeast = radians(4);
constexpr double kTurnMost = radians(40);
constexpr double kTurnNearByWay = radians(0.25) / 1000;
constexpr double kTurnFarLeast = radians(5);
constexpr double kDriftByWay = radians(0.05) / 1000;

}  // namespace

Uncertainty::Uncertainty(const Track& track, std::span<const Edge> loops) {
  double begin = -kStationEvery;
  std::size_t last = 0;
  double way = 0;
  for (std::size_t i = 0; i < track.keyframes.size(); ++i) {
    if (i > 0) {
      way += track.keyframes[i].travelled - track.keyframes[i - 1].travelled;
      way += kTurnWay * std::abs(signed_angle(track.poses[i].rho - track.poses[i - 1].rho));
      if (track.keyframes[i].placed == Placed::kByOdometry) way += kUnmatchedWay;
      if (track.keyframes[i].placed == Placed::kBySearch) way += kSearchedWay;
    }
    if (track.keyframes[i].travelled - begin >= kStationEvery || i == 0) {
      begin = track.keyframes[i].travelled;
      stations_.push_back({track.poses[i].x, track.poses[i].y});
      if (stations_.size() > 1) connect(last, stations_.size() - 1, way);
      last = stations_.size() - 1;
      way = 0;
    }
    station_of_.push_back(stations_.size() - 1);
  }
  for (const Edge& loop : loops) connect(station_of_[loop.from], station_of_[loop.to], kLoopWay);
}

void Uncertainty::connect(std::size_t a, std::size_t b, double mm) {
  stations_[a].next.emplace_back(b, mm);
  stations_[b].next.emplace_back(a, mm);
}

void Uncertainty::look_from(std::size_t at) {
  const std::size_t begin = station_of_[at];
  x_ = stations_[begin].x;
  y_ = stations_[begin].y;
  sums_.assign(stations_.size(), {});
  sums_[begin] = {.way = 0};
  using Next = std::pair<double, std::size_t>;
  std::priority_queue<Next, std::vector<Next>, std::greater<>> open;
  open.emplace(0, begin);
  while (!open.empty()) {
    const auto [way, i] = open.top();
    open.pop();
    if (way > sums_[i].way) continue;
    for (const auto& [j, mm] : stations_[i].next) {
      if (way + mm >= sums_[j].way) continue;
      const double x = (stations_[i].x + stations_[j].x) / 2 - x_;
      const double y = (stations_[i].y + stations_[j].y) / 2 - y_;
      sums_[j] = {.way = way + mm, .x = sums_[i].x + mm * x, .y = sums_[i].y + mm * y};
      open.emplace(way + mm, j);
    }
  }
}

double Uncertainty::way(std::size_t place) const { return sums_[station_of_[place]].way; }

Window Uncertainty::window(std::size_t place) const {
  const Sums& sums = sums_[station_of_[place]];
  // A drift of the heading moves the end by its lever at each part of the way: their sum.
  const double moved = kDriftByWay * std::hypot(sums.x, sums.y);
  const double by_way = std::min(kNearByWay * sums.way, kFarLeast + kFarByWay * sums.way);
  const double turn = std::min(kTurnNearByWay * sums.way, kTurnFarLeast + kDriftByWay * sums.way);
  return {.distance = std::min(kWindowLeast + by_way + moved, kWindowMost),
          .turn = std::min(kTurnLeast + turn, kTurnMost)};
}

}  // namespace rack::mapping
