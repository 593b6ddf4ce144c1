// What a drive looked like: a map, tracks on it, and below what changed with time. Pure.
//
// The map is drawn as maps are, north up: x of RACK upwards, y to the right, both with the same
// scale. What has the same unit shares a diagram. Colours are those of Okabe and Ito, which people
// who are colour-blind tell apart too; tracks of different kinds have different dashes besides.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "components/geometry/pose.h"
#include "components/localisation/grid_map.h"

namespace rack::plot {

enum class Role : std::uint8_t { kEstimate, kOdometry, kTruth, kPath, kOther };

struct Track {
  std::string name;
  Role role = Role::kOther;
  std::vector<double> times{};     // s; empty: not known
  std::vector<MapPoint> points{};  // mm
};

struct Series {
  std::string name;
  std::string unit;  // "m"
  Role role = Role::kOther;
  std::vector<double> times{};  // s
  std::vector<double> values{};
};

// Where something is, and looks.
struct Mark {
  std::string name;
  Pose at{};
  Role role = Role::kEstimate;
};

struct Picture {
  std::string title{};
  std::optional<localisation::GridMap> map{};
  std::vector<Track> tracks{};
  std::vector<MapPoint> dots{};  // samples of a filter
  std::vector<Mark> marks{};
  std::vector<Series> series{};

  [[nodiscard]] bool empty() const {
    return !map && tracks.empty() && dots.empty() && marks.empty() && series.empty();
  }
};

// How far each track is from the one that is the truth, where both have times; nothing when none is
// the truth.
std::vector<Series> errors_of(const std::vector<Track>& tracks);

// As SVG.
std::string draw(const Picture& picture);

// Values for an axis: 1, 2 or 5 times a power of ten apart, some `about` of them.
std::vector<double> ticks(double low, double high, int about);

}  // namespace rack::plot
