#include "components/localisation/ros_yaml.h"

#include <array>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include "base/text.h"

namespace rack::localisation {

namespace {

tims::Error not_a_description(std::string what) {
  return {tims::Errc::kMalformed, std::move(what)};
}

tims::Error in_line(const YAML::Mark& mark, const std::string& what) {
  if (mark.is_null()) return not_a_description(what);
  return not_a_description(fmt::format("line {}: {}", mark.line + 1, what));
}

std::string_view text_of(const YAML::Node& node) {
  return node.IsScalar() ? std::string_view(node.Scalar()) : std::string_view();
}

// yaml-cpp would also take "infinity" and what is not a number for none.
std::optional<double> finite_number(const YAML::Node& node) {
  std::string_view text = text_of(node);
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto value = tims::base::parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

// A text of the file in a message.
std::string shortened(const std::string& text) {
  return tims::base::printable(std::string_view(text).substr(0, 40));
}

// Empty, or why it is not valid; so are those below.
std::string take_origin(const YAML::Node& value, RosMapInfo& info) {
  constexpr const char* kForm = "origin: must be [x, y, theta]";
  constexpr double kTurned = 1e-6;  // rad; rounding is no rotation
  if (!value.IsSequence() || value.size() != 3) return kForm;
  constexpr std::array<const char*, 3> kNames = {"x", "y", "theta"};
  std::array<double, 3> origin{};
  for (std::size_t i = 0; i < origin.size(); ++i) {
    const auto number = finite_number(value[i]);
    if (!number && value[i].IsScalar())
      return fmt::format("{}; {} is \"{}\", which is not a number{}", kForm, kNames[i],
                         shortened(value[i].Scalar()),
                         i == 2 ? ": write 0 for a map that is not rotated" : "");
    if (!number) return kForm;
    origin[i] = *number;
  }
  if (std::abs(origin[2]) > kTurned)
    return "origin: rotated maps are not supported; rotate the image";
  info.origin_x = origin[0];
  info.origin_y = origin[1];
  return {};
}

std::string take_negate(const YAML::Node& value, RosMapInfo& info) {
  bool truth = false;
  if (YAML::convert<bool>::decode(value, truth))
    info.negate = truth;
  else if (const auto number = finite_number(value))
    info.negate = *number != 0;
  else
    return "negate: must be 0 or 1, or true or false";
  return {};
}

std::string take_mode(const YAML::Node& value, RosMapInfo& info) {
  const std::string_view mode = text_of(value);
  if (mode != "trinary" && mode != "scale" && mode != "raw")
    return "mode: must be trinary, scale or raw";
  info.is_raw = mode == "raw";
  return {};
}

std::string take_value(const std::string& key, const YAML::Node& value, RosMapInfo& info) {
  const auto number = [&](double& to) -> std::string {
    const auto parsed = finite_number(value);
    if (!parsed) return fmt::format("{}: not a number", key);
    to = *parsed;
    return {};
  };
  if (key == "resolution") return number(info.resolution);
  if (key == "occupied_thresh") return number(info.occupied_thresh);
  if (key == "free_thresh") return number(info.free_thresh);
  if (key == "origin") return take_origin(value, info);
  if (key == "negate") return take_negate(value, info);
  if (key == "mode") return take_mode(value, info);
  if (key != "image") return {};
  info.image = text_of(value);
  if (info.image.starts_with("~"))
    return "image: ~ is not replaced by a folder: write the whole path, or the path from this file";
  return info.image.empty() ? "image: must be the name of a file" : "";
}

tims::Result<RosMapInfo> read_document(const YAML::Node& document) {
  RosMapInfo info;
  if (!document.IsMap() && !document.IsNull())
    return in_line(document.Mark(), "expected `key: value`");
  std::set<std::string> seen;
  for (const auto& entry : document) {
    const YAML::Node& key = entry.first;
    const YAML::Node& value = entry.second;
    if (!key.IsScalar()) return in_line(key.Mark(), "expected `key: value`");
    if (!seen.insert(key.Scalar()).second) {
      info.remarks.push_back(fmt::format("line {}: {} is there twice; the first is used",
                                         key.Mark().line + 1, shortened(key.Scalar())));
      continue;
    }
    const std::string wrong = take_value(key.Scalar(), value, info);
    if (!wrong.empty()) return in_line(value.Mark(), wrong);
  }
  if (info.image.empty()) return not_a_description("no `image: FILE`");
  if (info.resolution < 0.001 || info.resolution > 10)
    return not_a_description("no `resolution: METRES` between 0.001 and 10");
  if (std::abs(info.origin_x) > 1e6 || std::abs(info.origin_y) > 1e6)
    return not_a_description("origin: more than 1000 km away");
  if (info.occupied_thresh < info.free_thresh)
    info.remarks.push_back(
        fmt::format("occupied_thresh {} is less than free_thresh {}: are they exchanged? What is "
                    "above the first is occupied",
                    info.occupied_thresh, info.free_thresh));
  return info;
}

}  // namespace

tims::Result<RosMapInfo> read_ros_yaml(std::string_view text) {
  if (text.size() > kRosYamlMax)
    return not_a_description("more than 64 KiB: this is not the description of a map");
  try {
    return read_document(YAML::Load(std::string(text)));
  } catch (const YAML::Exception& error) {
    return in_line(error.mark, error.msg);
  }
}

std::string to_ros_yaml(const GridMap& map, std::string_view image) {
  const RosMapInfo usual;
  YAML::Emitter yaml;
  const auto add = [&](const char* key, const auto& value) {
    yaml << YAML::Key << key << YAML::Value << value;
  };
  yaml << YAML::BeginMap;
  add("image", std::string(image));
  add("resolution", fmt::format("{}", map.resolution / 1000));
  yaml << YAML::Key << "origin" << YAML::Value << YAML::Flow << YAML::BeginSeq
       << fmt::format("{:.3f}", map.origin.y / 1000) << fmt::format("{:.3f}", map.origin.x / 1000)
       << "0.0" << YAML::EndSeq;
  add("negate", "0");
  add("occupied_thresh", fmt::format("{}", usual.occupied_thresh));
  add("free_thresh", fmt::format("{}", usual.free_thresh));
  yaml << YAML::EndMap;
  return std::string(yaml.c_str(), yaml.size()) + "\n";
}

}  // namespace rack::localisation
