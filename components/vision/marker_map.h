// A map of markers: AprilTags on the walls of a building, upright, and where they are. Its file is
// TOML, in mm and degrees (README.md). Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "base/toml.h"
#include "components/geometry/floor_map.h"

namespace rack::vision {

enum class Family : std::uint8_t { kTag36h11, kTag25h9, kTag16h5 };

std::string_view name_of(Family family);
std::optional<Family> family_of(std::string_view name);
// Number of different markers of a family.
int ids_of(Family family);

struct Marker {
  Family family = Family::kTag36h11;
  int id = 0;
  MapPoint at{};
  double rho = 0;     // direction that its face looks to
  double height = 0;  // mm above the ground, of its centre
  double size = 160;  // mm, side of the black square

  // Whether it looks the same.
  [[nodiscard]] bool is_like(const Marker& other) const {
    return family == other.family && id == other.id;
  }
};

struct MarkerFile {
  std::vector<Marker> markers{};  // valid only when there are no problems
  std::vector<tims::base::Problem> problems{};
};

// Reports every problem with file, line and column.
MarkerFile read_marker_map(const tims::base::TextFile& file);

}  // namespace rack::vision
