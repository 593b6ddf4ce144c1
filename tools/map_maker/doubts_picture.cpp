#include "tools/map_maker/doubts_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rack::map_maker {

namespace {

using localisation::Cell;
using Colour = std::array<std::uint8_t, 3>;

constexpr std::int32_t kSideMost = 4000;
constexpr Colour kWallColour{0, 0, 0};
constexpr Colour kFreeColour{254, 254, 254};
constexpr Colour kUnknownColour{205, 205, 205};
constexpr Colour kDriveColour{90, 140, 240};
constexpr Colour kSeenThroughColour{230, 30, 30};
constexpr Colour kPlaceColour{255, 140, 0};

class Sheet {
 public:
  explicit Sheet(const localisation::GridMap& map) : map_(map) {
    const std::int32_t side = std::max(map.rows, map.columns);
    cells_ = (side + kSideMost - 1) / kSideMost;
    picture_.width = (map.columns + cells_ - 1) / cells_;
    picture_.height = (map.rows + cells_ - 1) / cells_;
    picture_.rgb.resize(3 * static_cast<std::size_t>(picture_.width) *
                        static_cast<std::size_t>(picture_.height));
    for (std::int32_t row = 0; row < picture_.height; ++row)
      for (std::int32_t column = 0; column < picture_.width; ++column)
        put(row, column, colour_of(row, column));
  }
  // A dot of `size` pixels to both sides.
  void dot(const MapPoint& at, std::int32_t size, const Colour& colour) {
    const double pixel = map_.resolution * cells_;
    const double row = std::floor((at.x - map_.origin.x) / pixel);
    const double column = std::floor((at.y - map_.origin.y) / pixel);
    if (!(row >= 0 && column >= 0 && row < picture_.height && column < picture_.width)) return;
    for (std::int32_t r = -size; r <= size; ++r)
      for (std::int32_t c = -size; c <= size; ++c)
        put(static_cast<std::int32_t>(row) + r, static_cast<std::int32_t>(column) + c, colour);
  }
  ColourPicture take() { return std::move(picture_); }

 private:
  // Of the cells of a pixel, a wall is shown if there is any.
  [[nodiscard]] Colour colour_of(std::int32_t row, std::int32_t column) const {
    bool is_free = false;
    for (std::int32_t r = row * cells_; r < std::min((row + 1) * cells_, map_.rows); ++r)
      for (std::int32_t c = column * cells_; c < std::min((column + 1) * cells_, map_.columns);
           ++c) {
        if (map_.at(r, c) == Cell::kOccupied) return kWallColour;
        is_free = is_free || map_.at(r, c) == Cell::kFree;
      }
    return is_free ? kFreeColour : kUnknownColour;
  }
  // Row 0 of a picture is in the north.
  void put(std::int32_t row, std::int32_t column, const Colour& colour) {
    if (row < 0 || column < 0 || row >= picture_.height || column >= picture_.width) return;
    const auto at = 3 * (static_cast<std::size_t>(picture_.height - 1 - row) *
                             static_cast<std::size_t>(picture_.width) +
                         static_cast<std::size_t>(column));
    for (std::size_t i = 0; i < 3; ++i) picture_.rgb[at + i] = std::byte{colour[i]};
  }

  const localisation::GridMap& map_;
  std::int32_t cells_ = 1;  // of a side of a pixel
  ColourPicture picture_;
};

}  // namespace

ColourPicture draw_doubts(const mapping::MadeMap& made) {
  Sheet sheet(made.map);
  for (const Pose& pose : made.poses) sheet.dot({pose.x, pose.y}, 0, kDriveColour);
  for (const MapPoint& place : made.doubts.places) sheet.dot(place, 3, kPlaceColour);
  for (const MapPoint& wall : made.doubts.walls) sheet.dot(wall, 1, kSeenThroughColour);
  return sheet.take();
}

}  // namespace rack::map_maker
