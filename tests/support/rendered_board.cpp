#include "tests/support/rendered_board.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace tims::test {
namespace {

using rack::camera_calibrate::Board;
using rack::camera_calibrate::BoardKind;
using Vector = std::array<double, 3>;

// Displaces a direction as the lens does.
std::array<double, 2> through_lens(const std::vector<double>& k, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

std::array<double, 2> before_lens(const std::vector<double>& k, double x, double y) {
  std::array<double, 2> ray = {x, y};
  for (int i = 0; i < 40; ++i) {
    const auto seen = through_lens(k, ray[0], ray[1]);
    const double left_x = x - seen[0];
    const double left_y = y - seen[1];
    ray[0] += left_x;
    ray[1] += left_y;
    if (std::abs(left_x) + std::abs(left_y) < 1e-10) break;
  }
  return ray;
}

// Columns of the rotation: the axes of the board in the frame of the camera.
std::array<Vector, 3> axes_of(const BoardPose& pose) {
  const double sx = std::sin(pose.turn_x), cx = std::cos(pose.turn_x);
  const double sy = std::sin(pose.turn_y), cy = std::cos(pose.turn_y);
  const double sz = std::sin(pose.turn_z), cz = std::cos(pose.turn_z);
  return {{{cz * cy, sz * cy, -sy},
           {cz * sy * sx - sz * cx, sz * sy * sx + cz * cx, cy * sx},
           {cz * sy * cx + sz * sx, sz * sy * cx - cz * sx, cy * cx}}};
}

std::array<double, 2> extent_of(const Board& board) {
  const auto all = rack::camera_calibrate::positions(board);
  std::array<double, 2> extent{};
  for (const auto& position : all) {
    extent[0] = std::max(extent[0], position.x);
    extent[1] = std::max(extent[1], position.y);
  }
  return extent;
}

constexpr double kInk = 0.08;
constexpr double kPaper = 0.92;
constexpr double kTable = 0.4;

double brightness_of(const Board& board, const std::array<double, 2>& extent, double x, double y) {
  const double s = board.square;
  if (x < -2 * s || y < -2 * s || x > extent[0] + 2 * s || y > extent[1] + 2 * s) return kTable;
  if (board.kind == BoardKind::kChessboard) {
    if (x < -s || y < -s || x > extent[0] + s || y > extent[1] + s) return kPaper;
    const auto square = static_cast<long>(std::floor(x / s)) + static_cast<long>(std::floor(y / s));
    return square % 2 == 0 ? kPaper : kInk;
  }
  const bool is_asymmetric = board.kind == BoardKind::kAsymmetricCircles;
  const double row = std::round(y / s);
  const double shift = is_asymmetric && static_cast<long>(row) % 2 != 0 ? s : 0;
  const double step = is_asymmetric ? 2 * s : s;
  const double column = std::round((x - shift) / step);
  if (row < 0 || row >= board.rows || column < 0 || column >= board.columns) return kPaper;
  const double radius = (is_asymmetric ? 0.5 : 0.3) * s;
  return std::hypot(x - shift - column * step, y - row * s) < radius ? kInk : kPaper;
}

void blur(std::vector<double>& picture, int width, int height) {
  const std::vector<double> from = picture;
  const auto at = [&](int x, int y) {
    return from[static_cast<std::size_t>(std::clamp(y, 0, height - 1)) *
                    static_cast<std::size_t>(width) +
                static_cast<std::size_t>(std::clamp(x, 0, width - 1))];
  };
  std::size_t i = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          sum += (dx == 0 ? 0.5 : 0.25) * (dy == 0 ? 0.5 : 0.25) * at(x + dx, y + dy);
      picture[i++] = sum;
    }
}

}  // namespace

RenderedCamera::RenderedCamera(rack::pictures::CameraCalibration calibration, int samples)
    : calibration_(std::move(calibration)), samples_(samples) {
  const auto& camera = calibration_.camera;
  for (int y = 0; y < calibration_.height; ++y)
    for (int x = 0; x < calibration_.width; ++x)
      for (int j = 0; j < samples; ++j)
        for (int i = 0; i < samples; ++i) {
          const double u = x + (i + 0.5) / samples - 0.5;
          const double v = y + (j + 0.5) / samples - 0.5;
          const auto ray = before_lens(calibration_.distortion, (u - camera.cx) / camera.fx,
                                       (v - camera.cy) / camera.fy);
          rays_.push_back({static_cast<float>(ray[0]), static_cast<float>(ray[1])});
        }
}

std::vector<std::byte> RenderedCamera::render(const Brightness& brightness,
                                              const PictureFaults& faults) const {
  const auto side = static_cast<std::size_t>(samples_);
  const std::size_t per_pixel = side * side;
  std::vector<double> picture(rays_.size() / per_pixel);
  for (std::size_t i = 0; i < rays_.size(); ++i)
    picture[i / per_pixel] +=
        255 * brightness(rays_[i].x, rays_[i].y) / static_cast<double>(per_pixel);
  for (int i = 0; i < faults.blur; ++i) blur(picture, calibration_.width, calibration_.height);
  std::mt19937 random(faults.seed);
  std::normal_distribution<double> noise(0, std::max(faults.noise, 1e-9));
  std::vector<std::byte> pixels;
  pixels.reserve(picture.size());
  for (const double value : picture)
    pixels.push_back(
        static_cast<std::byte>(std::clamp(std::lround(value + noise(random)), 0L, 255L)));
  return pixels;
}

std::vector<std::byte> RenderedCamera::render(const Board& board, const BoardPose& pose,
                                              const PictureFaults& faults) const {
  const auto axes = axes_of(pose);
  const auto extent = extent_of(board);
  const Vector middle = {pose.x, pose.y, pose.z};
  const auto dot = [](const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  const double distance = dot(axes[2], middle);
  return render(
      [&](double x, double y) {
        const Vector ray = {x, y, 1};
        const double towards = dot(axes[2], ray);
        if (towards * distance <= 0) return kTable;
        const double along = distance / towards;
        const Vector hit = {ray[0] * along - middle[0], ray[1] * along - middle[1],
                            ray[2] * along - middle[2]};
        return brightness_of(board, extent, dot(axes[0], hit) + extent[0] / 2,
                             dot(axes[1], hit) + extent[1] / 2);
      },
      faults);
}

std::array<double, 2> RenderedCamera::pixel_of(double x, double y, double z) const {
  const auto& camera = calibration_.camera;
  const auto seen = through_lens(calibration_.distortion, x / z, y / z);
  return {camera.fx * seen[0] + camera.cx, camera.fy * seen[1] + camera.cy};
}

std::vector<rack::camera_calibrate::PicturePoint> RenderedCamera::seen(
    const Board& board, const BoardPose& pose) const {
  const auto axes = axes_of(pose);
  const auto extent = extent_of(board);
  std::vector<rack::camera_calibrate::PicturePoint> points;
  for (const auto& position : rack::camera_calibrate::positions(board)) {
    const double x = position.x - extent[0] / 2;
    const double y = position.y - extent[1] / 2;
    const auto pixel =
        pixel_of(pose.x + axes[0][0] * x + axes[1][0] * y, pose.y + axes[0][1] * x + axes[1][1] * y,
                 pose.z + axes[0][2] * x + axes[1][2] * y);
    points.push_back({static_cast<float>(pixel[0]), static_cast<float>(pixel[1])});
  }
  return points;
}

bool RenderedCamera::shows(const Board& board, const BoardPose& pose) const {
  const auto axes = axes_of(pose);
  const auto extent = extent_of(board);
  const double margin = 1.5 * board.square;
  for (const double side_x : {-1.0, 1.0})
    for (const double side_y : {-1.0, 1.0}) {
      const double x = side_x * (extent[0] / 2 + margin);
      const double y = side_y * (extent[1] / 2 + margin);
      const double z = pose.z + axes[0][2] * x + axes[1][2] * y;
      if (z < 0.1 * pose.z) return false;
      const auto pixel = pixel_of(pose.x + axes[0][0] * x + axes[1][0] * y,
                                  pose.y + axes[0][1] * x + axes[1][1] * y, z);
      if (pixel[0] < 1 || pixel[1] < 1 || pixel[0] > calibration_.width - 2 ||
          pixel[1] > calibration_.height - 2)
        return false;
    }
  return true;
}

std::vector<BoardPose> RenderedCamera::poses(const Board& board, std::size_t count, double tilt,
                                             std::uint32_t seed) const {
  std::mt19937 random(seed);
  const auto between = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  const double width = extent_of(board)[0] + 2 * board.square;
  const auto& camera = calibration_.camera;
  std::vector<BoardPose> poses;
  for (int tries = 0; poses.size() < count && tries < 100000; ++tries) {
    // The board's middle is in the parts of the picture in turn.
    const std::size_t column = poses.size() % 3;
    const std::size_t row = poses.size() / 3 % 3;
    const double u = calibration_.width * (static_cast<double>(column) + between(0, 1)) / 3;
    const double v = calibration_.height * (static_cast<double>(row) + between(0, 1)) / 3;
    const double z = camera.fx * width / (between(0.4, 0.75) * calibration_.width);
    const BoardPose pose{.x = (u - camera.cx) / camera.fx * z,
                         .y = (v - camera.cy) / camera.fy * z,
                         .z = z,
                         .turn_x = between(-tilt, tilt),
                         .turn_y = between(-tilt, tilt),
                         .turn_z = between(-0.2, 0.2)};
    if (shows(board, pose)) poses.push_back(pose);
  }
  return poses;
}

std::string pgm_of(const std::vector<std::byte>& pixels, int width, int height) {
  std::string text = "P5\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  text.append(reinterpret_cast<const char*>(pixels.data()), pixels.size());
  return text;
}

}  // namespace tims::test
