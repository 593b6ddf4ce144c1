// A picture of a drive: a map with trajectories, and diagrams over time below. Pure.
//
// The map has north up: x of RACK upwards, y to the right, with the same scale. Series with the
// same unit share a diagram. The colours are those of Okabe and Ito, which colour-blind people can
// distinguish; in addition, trajectories of different roles have different dashes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "components/geometry/pose.h"
#include "components/localisation/grid_map.h"
#include "components/pictures/raster_canvas.h"
#include "tims/result.h"

namespace rack::plot {

enum class Role : std::uint8_t { kEstimate, kOdometry, kTruth, kPath, kOther };

struct Trajectory {
  std::string name;
  Role role = Role::kOther;
  std::vector<double> times{};     // s; empty: unknown
  std::vector<MapPoint> points{};  // mm
};

struct Series {
  std::string name;
  std::string unit;  // "m"
  Role role = Role::kOther;
  std::vector<double> times{};  // s
  std::vector<double> values{};
};

// A position with a heading.
struct Mark {
  std::string name;
  Pose at{};
  Role role = Role::kEstimate;
};

struct Picture {
  std::string title{};
  std::optional<localisation::GridMap> map{};
  std::vector<Trajectory> trajectories{};
  std::vector<MapPoint> dots{};  // samples of a filter
  std::vector<Mark> marks{};
  std::vector<Series> series{};

  [[nodiscard]] bool empty() const {
    return !map && trajectories.empty() && dots.empty() && marks.empty() && series.empty();
  }
};

// The distance of each trajectory to the true one, where both have times. Empty without a true one.
std::vector<Series> errors_of(const std::vector<Trajectory>& trajectories);

std::string to_svg(const Picture& picture);

// `draw_png`: of librack-pictures. Error: the picture is too large, because it has very many
// curves.
tims::Result<std::string> to_png(const Picture& picture, pictures::DrawPng draw_png);

// About `about` tick values of an axis, at intervals of 1, 2 or 5 times a power of ten.
std::vector<double> ticks(double low, double high, int about);

}  // namespace rack::plot
