#include "components/localisation/ros_map.h"

#include <cmath>
#include <vector>

#include <fmt/core.h>

#include "base/text.h"

namespace rack::localisation {

namespace {

constexpr std::string_view kRosMapBlank = " \t\r\n\f\v";
constexpr std::int64_t kPixelsMax = 128'000'000;  // 500 m x 500 m with cells of 50 mm

tims::Error malformed(std::string what) { return {tims::Errc::kMalformed, std::move(what)}; }

// The header of an image: tokens with comments between them.
class PgmReader {
 public:
  explicit PgmReader(std::string_view bytes) : left_(bytes) {}

  std::string_view token() {
    for (;;) {
      const auto first = left_.find_first_not_of(kRosMapBlank);
      left_.remove_prefix(std::min(first, left_.size()));
      if (!left_.starts_with('#')) break;
      left_.remove_prefix(std::min(left_.find('\n'), left_.size()));
    }
    const std::string_view found = left_.substr(0, left_.find_first_of(kRosMapBlank));
    left_.remove_prefix(found.size());
    return found;
  }
  std::int64_t number() { return tims::base::parse_number<std::int32_t>(token()).value_or(-1); }
  // The next `count` bytes after exactly one blank; empty when there are fewer.
  std::string_view bytes(std::size_t count) {
    if (left_.size() < count + 1) return {};
    return left_.substr(1, count);
  }

 private:
  std::string_view left_;
};

struct Picture {
  std::int32_t width;
  std::int32_t height;
  double white;
  std::vector<std::uint16_t> values;  // from the top row
};

tims::Result<Picture> read_pgm(std::string_view bytes) {
  PgmReader reader(bytes);
  const std::string_view kind = reader.token();
  if (kind != "P5" && kind != "P2")
    return malformed("not a PGM image: it must begin with P5 or P2");
  const std::int64_t width = reader.number();
  const std::int64_t height = reader.number();
  const std::int64_t white = reader.number();
  if (width <= 0 || height <= 0) return malformed("the PGM image has no valid size");
  if (width * height > kPixelsMax)
    return malformed("the image has more than " + std::to_string(kPixelsMax) +
                     " pixels: crop it, or reduce its resolution");
  if (white <= 0 || white > 65535)
    return malformed("the maximum value of the PGM image is not 1 to 65535");
  Picture picture{static_cast<std::int32_t>(width),
                  static_cast<std::int32_t>(height),
                  static_cast<double>(white),
                  {}};
  const auto count = static_cast<std::size_t>(width * height);
  if (kind == "P5") {
    const std::size_t size = white > 255 ? 2 : 1;
    const std::string_view raw = reader.bytes(count * size);
    if (raw.empty()) return malformed("the PGM image ends before its last row");
    picture.values.reserve(count);
    for (std::size_t i = 0; i < raw.size(); i += size) {
      unsigned value = static_cast<unsigned char>(raw[i]);
      if (size == 2) value = value << 8U | static_cast<unsigned char>(raw[i + 1]);
      picture.values.push_back(static_cast<std::uint16_t>(value));
    }
    return picture;
  }
  if (bytes.size() < count) return malformed("the PGM image ends before its last row");
  picture.values.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t value = reader.number();
    if (value < 0 || value > white)
      return malformed("pixel " + std::to_string(i) + " of the PGM image is not a valid value");
    picture.values.push_back(static_cast<std::uint16_t>(value));
  }
  return picture;
}

}  // namespace

tims::Result<GridMap> read_ros_map(const RosMapInfo& info, std::string_view pgm) {
  const auto picture = read_pgm(pgm);
  if (!picture) return picture.error();
  GridMap map{.resolution = info.resolution * 1000,
              .origin = {info.origin_y * 1000, info.origin_x * 1000},
              .rows = picture->height,
              .columns = picture->width};
  const auto columns = static_cast<std::size_t>(map.columns);
  map.cells.resize(picture->values.size());
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const std::uint16_t value = picture->values[i];
    const double bright = value / picture->white;
    // Raw values are per cent; above 100 is unknown.
    const double occupied = info.is_raw ? value / 100.0 : info.negate ? bright : 1 - bright;
    const bool is_unknown = info.is_raw && value > 100;
    const std::size_t row = static_cast<std::size_t>(map.rows) - 1 - i / columns;
    map.cells[row * columns + i % columns] = is_unknown                        ? Cell::kUnknown
                                             : occupied > info.occupied_thresh ? Cell::kOccupied
                                             : occupied < info.free_thresh     ? Cell::kFree
                                                                               : Cell::kUnknown;
  }
  return map;
}

std::string to_pgm(const GridMap& map) {
  std::string pgm = fmt::format("P5\n{} {}\n255\n", map.columns, map.rows);
  pgm.reserve(pgm.size() + map.cells.size());
  for (std::int32_t row = map.rows - 1; row >= 0; --row)
    for (std::int32_t column = 0; column < map.columns; ++column) {
      const Cell cell = map.at(row, column);
      // Grey values as ROS's map_saver writes them.
      constexpr int kBlack = 0;
      constexpr int kWhite = 254;
      constexpr int kGrey = 205;
      pgm.push_back(static_cast<char>(cell == Cell::kOccupied ? kBlack
                                      : cell == Cell::kFree   ? kWhite
                                                              : kGrey));
    }
  return pgm;
}

Pose pose_of_ros(double x, double y, double theta) {
  return {.x = y * 1000, .y = x * 1000, .rho = kPi / 2 - theta};
}

RosPose ros_of_pose(const Pose& pose) {
  return {pose.y / 1000, pose.x / 1000, signed_angle(kPi / 2 - pose.rho)};
}

}  // namespace rack::localisation
