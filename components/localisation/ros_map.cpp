#include "components/localisation/ros_map.h"

#include <cmath>
#include <optional>
#include <vector>

#include <fmt/core.h>

#include "base/text.h"

namespace rack::localisation {

namespace {

constexpr std::string_view kRosMapBlank = " \t\r\n\f\v";

tims::Error malformed(std::string what) { return {tims::Errc::kMalformed, std::move(what)}; }

std::string_view without_quotes(std::string_view text) {
  if (text.size() >= 2 && (text.front() == '"' || text.front() == '\'') &&
      text.back() == text.front())
    return text.substr(1, text.size() - 2);
  return text;
}

std::optional<double> finite(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto value = tims::base::parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

// Parses "[-27.2, -48.3, 0.0]"; empty when it is not a list of numbers.
std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  if (!text.starts_with('[') || !text.ends_with(']')) return {};
  text = text.substr(1, text.size() - 2);
  while (!text.empty()) {
    const auto comma = text.find(',');
    const auto value = finite(tims::base::trimmed(text.substr(0, comma), kRosMapBlank));
    if (!value) return {};
    numbers.push_back(*value);
    text = comma == std::string_view::npos ? std::string_view{} : text.substr(comma + 1);
  }
  return numbers;
}

// Empty, or the reason why the line is malformed.
std::string take(std::string_view key, std::string_view value, RosMapInfo& info) {
  const auto number = [&](double& to) -> std::string {
    const auto parsed = finite(value);
    if (!parsed) return std::string(key) + ": not a number";
    to = *parsed;
    return {};
  };
  if (key == "resolution") return number(info.resolution);
  if (key == "occupied_thresh") return number(info.occupied_thresh);
  if (key == "free_thresh") return number(info.free_thresh);
  if (key == "image") {
    info.image = without_quotes(value);
  } else if (key == "negate") {
    if (value != "0" && value != "1" && value != "true" && value != "false")
      return "negate: must be 0 or 1";
    info.negate = value == "1" || value == "true";
  } else if (key == "origin") {
    const auto origin = numbers_of(value);
    if (origin.size() != 3) return "origin: must be [x, y, theta]";
    if (origin[2] != 0) return "origin: rotated maps are not supported; rotate the image";
    info.origin_x = origin[0];
    info.origin_y = origin[1];
  } else if (key == "mode") {
    const std::string_view mode = without_quotes(value);
    if (mode != "trinary" && mode != "scale" && mode != "raw")
      return "mode: must be trinary, scale or raw";
    info.is_raw = mode == "raw";
  }
  return {};
}

}  // namespace

tims::Result<RosMapInfo> read_ros_yaml(std::string_view text) {
  RosMapInfo info;
  std::string_view list_key;
  std::string list;
  int listed = 0;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (const auto comment = line.find('#');
        comment == 0 || (comment != std::string_view::npos &&
                         (line[comment - 1] == ' ' || line[comment - 1] == '\t')))
      line = line.substr(0, comment);
    line = tims::base::trimmed(line, kRosMapBlank);
    if (line.empty() || line == "---" || line == "...") continue;
    const std::string at = "line " + std::to_string(number) + ": ";
    // A list may follow its key as one number a line.
    if (line.starts_with("- ")) {
      if (list_key != "origin") return malformed(at + "a list without a known key");
      list += (list.empty() ? "" : ", ") +
              std::string(tims::base::trimmed(line.substr(2), kRosMapBlank));
      if (++listed < 3) continue;
      const std::string wrong = take("origin", "[" + list + "]", info);
      if (!wrong.empty()) return malformed(at + wrong);
      continue;
    }
    if (listed > 0 && listed < 3) return malformed(at + "origin: must be [x, y, theta]");
    const auto colon = line.find(':');
    if (colon == std::string_view::npos) return malformed(at + "expected `key: value`");
    list_key = tims::base::trimmed(line.substr(0, colon), kRosMapBlank);
    const std::string_view value = tims::base::trimmed(line.substr(colon + 1), kRosMapBlank);
    if (value.empty() && list_key == "origin") continue;
    const std::string wrong = take(list_key, value, info);
    if (!wrong.empty()) return malformed(at + wrong);
  }
  if (listed > 0 && listed < 3) return malformed("origin: must be [x, y, theta]");
  if (info.image.empty()) return malformed("no `image: FILE`");
  if (info.resolution < 0.001 || info.resolution > 10)
    return malformed("no `resolution: METRES` between 0.001 and 10");
  if (std::abs(info.origin_x) > 1e6 || std::abs(info.origin_y) > 1e6)
    return malformed("origin: more than 1000 km away");
  return info;
}

GridMap grid_of(const RosMapInfo& info, const pictures::GreyPicture& picture) {
  GridMap map{.resolution = info.resolution * 1000,
              .origin = {info.origin_y * 1000, info.origin_x * 1000},
              .rows = picture.height,
              .columns = picture.width};
  const auto columns = static_cast<std::size_t>(map.columns);
  map.cells.resize(picture.values.size());
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const std::uint16_t value = picture.values[i];
    const double bright = static_cast<double>(value) / picture.white;
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

std::string to_ros_yaml(const GridMap& map, std::string_view image) {
  const RosMapInfo usual;
  return fmt::format(
      "image: {}\nresolution: {}\norigin: [{:.3f}, {:.3f}, 0.0]\nnegate: 0\n"
      "occupied_thresh: {}\nfree_thresh: {}\n",
      image, map.resolution / 1000, map.origin.y / 1000, map.origin.x / 1000, usual.occupied_thresh,
      usual.free_thresh);
}

Pose pose_of_ros(double x, double y, double theta) {
  return {.x = y * 1000, .y = x * 1000, .rho = kPi / 2 - theta};
}

RosPose ros_of_pose(const Pose& pose) {
  return {pose.y / 1000, pose.x / 1000, signed_angle(kPi / 2 - pose.rho)};
}

}  // namespace rack::localisation
