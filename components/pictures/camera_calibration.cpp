#include "components/pictures/camera_calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include "base/text.h"

namespace rack::pictures {
namespace {

constexpr double kFocalMax = 1e6;        // pixels
constexpr double kDistortionMax = 1e4;   // of a coefficient
constexpr double kShiftMax = 1e9;        // pixels * m
constexpr std::size_t kNameMax = 100;    // bytes
constexpr double kRotationError = 1e-3;  // of a product of two rows
constexpr double kSkewMax = 1e-6;        // pixels
constexpr const char* kPlumbBob = "plumb_bob";
constexpr const char* kRational = "rational_polynomial";

tims::Error not_a_calibration(std::string what) {
  return {tims::Errc::kMalformed, std::move(what)};
}

tims::Error at_line(const YAML::Mark& mark, const std::string& what) {
  if (mark.is_null()) return not_a_calibration(what);
  return not_a_calibration(fmt::format("line {}: {}", mark.line + 1, what));
}

// yaml-cpp would also take "infinity" and what is not a number for none.
std::optional<double> number_of(const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  std::string_view text = node.Scalar();
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto value = tims::base::parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

// What the file contains, before it is checked as a whole.
struct CalibrationKeys {
  CameraCalibration calibration{};
  std::string model = kPlumbBob;
  std::vector<double> camera{};
  std::vector<double> rectification{};
  std::vector<double> projection{};
};

// Empty, or why it is not valid; so are those below.
std::string take_side(const std::string& key, const YAML::Node& value, std::int32_t& side) {
  const auto number = number_of(value);
  if (!number || *number < 1 || *number > kCalibrationSideMax || *number != std::floor(*number))
    return fmt::format("{}: must be 1 to {} pixels", key, kCalibrationSideMax);
  side = static_cast<std::int32_t>(*number);
  return {};
}

std::string take_name(const YAML::Node& value, std::string& name) {
  if (!value.IsScalar() || !is_camera_name(value.Scalar()))
    return fmt::format("camera_name: must be a text of at most {} ASCII characters", kNameMax);
  name = value.Scalar();
  return {};
}

// "{rows: 3, cols: 3, data: [...]}".
std::string take_matrix(const std::string& key, const YAML::Node& value, std::size_t rows,
                        std::size_t columns, std::vector<double>& numbers) {
  std::string form = columns == 0
                         ? fmt::format("{}: must have rows: 1, cols: 4, 5 or 8, data: [...]", key)
                         : fmt::format("{}: must have rows: {}, cols: {}, data: [{} numbers]", key,
                                       rows, columns, rows * columns);
  if (!value.IsMap()) return form;
  const auto has_rows = number_of(value["rows"]);
  const auto has_columns = number_of(value["cols"]);
  const YAML::Node data = value["data"];
  if (!has_rows || !has_columns || !data.IsSequence()) return form;
  // Coefficients are a row in files of ROS, a column in some of OpenCV.
  if (columns != 0
          ? *has_rows != static_cast<double>(rows) || *has_columns != static_cast<double>(columns)
          : *has_rows != 1 && *has_columns != 1)
    return form;
  constexpr std::size_t kNumbersMax = 12;
  if (data.size() > kNumbersMax || static_cast<double>(data.size()) != *has_rows * *has_columns)
    return form;
  numbers.clear();
  for (const YAML::Node& each : data) {
    const auto number = number_of(each);
    if (!number) return fmt::format("{}: data must be finite numbers", key);
    numbers.push_back(*number);
  }
  return {};
}

std::string take_model(const YAML::Node& value, std::string& model) {
  model = value.IsScalar() ? value.Scalar() : std::string();
  if (model == kPlumbBob || model == kRational) return {};
  return fmt::format("distortion_model: must be {} or {}; lenses of fisheyes are not supported",
                     kPlumbBob, kRational);
}

std::string take_key(const std::string& key, const YAML::Node& value, CalibrationKeys& keys) {
  CameraCalibration& calibration = keys.calibration;
  if (key == "image_width") return take_side(key, value, calibration.width);
  if (key == "image_height") return take_side(key, value, calibration.height);
  if (key == "camera_name") return take_name(value, calibration.name);
  if (key == "camera_matrix") return take_matrix(key, value, 3, 3, keys.camera);
  if (key == "distortion_model") return take_model(value, keys.model);
  if (key == "distortion_coefficients")
    return take_matrix(key, value, 1, 0, calibration.distortion);
  if (key == "rectification_matrix") return take_matrix(key, value, 3, 3, keys.rectification);
  if (key == "projection_matrix") return take_matrix(key, value, 3, 4, keys.projection);
  return {};
}

// Rows of 3 or 4 numbers.
std::string take_camera(const char* key, const std::vector<double>& rows, std::int32_t width,
                        std::int32_t height, CameraMatrix& camera) {
  const std::size_t columns = rows.size() / 3;
  const auto at = [&](std::size_t row, std::size_t column) { return rows[row * columns + column]; };
  camera = {.fx = at(0, 0), .fy = at(1, 1), .cx = at(0, 2), .cy = at(1, 2)};
  if (std::abs(at(0, 1)) > kSkewMax || at(1, 0) != 0 || at(2, 0) != 0 || at(2, 1) != 0 ||
      at(2, 2) != 1)
    return fmt::format("{}: must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]", key);
  if (camera.fx == 0 && camera.fy == 0)
    return fmt::format("{}: fx and fy are 0: the camera was not calibrated", key);
  const auto is_focal = [](double f) { return f >= 1 && f <= kFocalMax; };
  if (!is_focal(camera.fx) || !is_focal(camera.fy))
    return fmt::format("{}: fx and fy must be 1 to {} pixels", key, kFocalMax);
  if (std::abs(camera.cx) > 2.0 * width || std::abs(camera.cy) > 2.0 * height)
    return fmt::format("{}: cx and cy are far outside of the picture", key);
  return {};
}

bool is_rotation(std::span<const double, 9> rows) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i; j < 3; ++j) {
      double product = 0;
      for (std::size_t k = 0; k < 3; ++k) product += rows[3 * i + k] * rows[3 * j + k];
      if (!(std::abs(product - (i == j ? 1 : 0)) < kRotationError)) return false;
    }
  return true;
}

std::string take_rectification(const CalibrationKeys& keys, CameraCalibration& calibration) {
  if (!keys.rectification.empty()) {
    std::ranges::copy(keys.rectification, calibration.rotation.begin());
    if (!is_rotation(calibration.rotation)) return "rectification_matrix: is not a rotation";
  }
  calibration.rectified = calibration.camera;
  if (keys.projection.empty()) return {};
  for (std::size_t i = 0; i < 3; ++i) {
    calibration.shift.at(i) = keys.projection[4 * i + 3];
    if (std::abs(calibration.shift.at(i)) > kShiftMax)
      return "projection_matrix: the last column is too large";
  }
  return take_camera("projection_matrix", keys.projection, calibration.width, calibration.height,
                     calibration.rectified);
}

std::string take_distortion(const CalibrationKeys& keys, CameraCalibration& calibration) {
  auto& numbers = calibration.distortion;
  if (!std::ranges::all_of(numbers, [](double k) { return std::abs(k) <= kDistortionMax; }))
    return "distortion_coefficients: are too large";
  if (keys.model == kPlumbBob && numbers.size() == 4) numbers.push_back(0);
  const std::size_t wanted = keys.model == kPlumbBob ? 5 : 8;
  if (numbers.size() != wanted)
    return fmt::format("distortion_coefficients: {} requires {}", keys.model, wanted);
  return {};
}

tims::Result<CameraCalibration> checked(CalibrationKeys keys) {
  CameraCalibration& calibration = keys.calibration;
  if (calibration.width == 0 || calibration.height == 0)
    return not_a_calibration("no image_width and image_height: this is not a calibration of ROS");
  if (keys.camera.empty()) return not_a_calibration("no camera_matrix");
  if (calibration.distortion.empty()) return not_a_calibration("no distortion_coefficients");
  std::string wrong = take_camera("camera_matrix", keys.camera, calibration.width,
                                  calibration.height, calibration.camera);
  if (wrong.empty()) wrong = take_distortion(keys, calibration);
  if (wrong.empty()) wrong = take_rectification(keys, calibration);
  if (!wrong.empty()) return not_a_calibration(wrong);
  return std::move(calibration);
}

tims::Result<CameraCalibration> read_calibration_node(const YAML::Node& document) {
  if (!document.IsMap()) return at_line(document.Mark(), "expected `key: value`");
  CalibrationKeys keys;
  for (const auto& entry : document) {
    if (!entry.first.IsScalar()) return at_line(entry.first.Mark(), "expected `key: value`");
    const std::string wrong = take_key(entry.first.Scalar(), entry.second, keys);
    if (!wrong.empty()) return at_line(entry.second.Mark(), wrong);
  }
  return checked(std::move(keys));
}

void put_matrix(YAML::Emitter& yaml, const char* key, std::size_t rows,
                std::span<const double> numbers) {
  yaml << YAML::Key << key << YAML::Value << YAML::BeginMap;
  yaml << YAML::Key << "rows" << YAML::Value << rows;
  yaml << YAML::Key << "cols" << YAML::Value << numbers.size() / rows;
  yaml << YAML::Key << "data" << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const double number : numbers) yaml << fmt::format("{}", number);
  yaml << YAML::EndSeq << YAML::EndMap;
}

std::string comment_of(std::string_view remark) {
  std::string comment;
  while (!remark.empty()) {
    const std::size_t end = std::min(remark.find('\n'), remark.size());
    comment += fmt::format("# {}\n", remark.substr(0, end));
    remark.remove_prefix(std::min(end + 1, remark.size()));
  }
  return comment;
}

CameraMatrix scaled(const CameraMatrix& camera, double x, double y) {
  // The corner of the picture is half a pixel before the centre of its first pixel.
  return {.fx = camera.fx * x,
          .fy = camera.fy * y,
          .cx = (camera.cx + 0.5) * x - 0.5,
          .cy = (camera.cy + 0.5) * y - 0.5};
}

}  // namespace

bool is_camera_name(std::string_view name) {
  return name.size() <= kNameMax &&
         std::ranges::all_of(name, [](char c) { return c >= ' ' && c <= '~'; });
}

tims::Result<CameraCalibration> read_calibration(std::string_view text) {
  if (text.size() > kCalibrationFileMax)
    return not_a_calibration("more than 64 KiB: this is not the calibration of a camera");
  try {
    return read_calibration_node(YAML::Load(std::string(text)));
  } catch (const YAML::Exception& error) {
    return at_line(error.mark, error.msg);
  }
}

std::string to_yaml(const CameraCalibration& calibration, std::string_view remark) {
  const CameraMatrix& camera = calibration.camera;
  const CameraMatrix& rectified = calibration.rectified;
  YAML::Emitter yaml;
  yaml << YAML::BeginMap;
  yaml << YAML::Key << "image_width" << YAML::Value << calibration.width;
  yaml << YAML::Key << "image_height" << YAML::Value << calibration.height;
  yaml << YAML::Key << "camera_name" << YAML::Value << calibration.name;
  put_matrix(yaml, "camera_matrix", 3,
             std::array{camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0});
  yaml << YAML::Key << "distortion_model" << YAML::Value
       << (calibration.distortion.size() > 5 ? kRational : kPlumbBob);
  put_matrix(yaml, "distortion_coefficients", 1, calibration.distortion);
  put_matrix(yaml, "rectification_matrix", 3, calibration.rotation);
  put_matrix(yaml, "projection_matrix", 3,
             std::array{rectified.fx, 0.0, rectified.cx, calibration.shift[0], 0.0, rectified.fy,
                        rectified.cy, calibration.shift[1], 0.0, 0.0, 1.0, calibration.shift[2]});
  yaml << YAML::EndMap;
  return comment_of(remark) + std::string(yaml.c_str(), yaml.size()) + "\n";
}

CameraCalibration scaled(const CameraCalibration& calibration, std::int32_t width,
                         std::int32_t height) {
  CameraCalibration result = calibration;
  const double x = static_cast<double>(width) / calibration.width;
  const double y = static_cast<double>(height) / calibration.height;
  result.width = width;
  result.height = height;
  result.camera = scaled(calibration.camera, x, y);
  result.rectified = scaled(calibration.rectified, x, y);
  result.shift[0] *= x;
  result.shift[1] *= y;
  return result;
}

tims::Result<CameraCalibration> calibration_for(const CameraCalibration& calibration,
                                                std::int32_t width, std::int32_t height) {
  // A side that the camera rounded may differ by less than a pixel.
  const double expected =
      static_cast<double>(width) * calibration.height / std::max(calibration.width, 1);
  if (width < 1 || height < 1 || std::abs(expected - height) >= 1)
    return tims::Error(
        tims::Errc::kInvalidArgument,
        fmt::format(
            "the calibration is for pictures of {}x{} pixels, those of the camera have {}x{}, "
            "another aspect ratio: set width and height, or calibrate with pictures of this "
            "size (camera-calibrate)",
            calibration.width, calibration.height, width, height));
  return scaled(calibration, width, height);
}

}  // namespace rack::pictures
