// Views of the board: how they differ, and which ones are missing for a calibration. Pure.
//
// A camera is known well when the board was seen in all parts of the picture (the distortion of the
// lens is largest at the edges), tilted in both directions (only then the focal length can be
// separated from the distance), and near enough.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/camera_calibrate/board.h"

namespace rack::camera_calibrate {

struct View {
  std::string name{};  // of the picture
  std::vector<PicturePoint> points{};
};

// How the board lies in the picture; 1 is the width (x, size) or height (y) of the picture.
struct ViewShape {
  double x = 0;  // centre of the points
  double y = 0;
  double size = 0;    // square root of the area of the points, in that of the picture's
  double tilt_x = 0;  // logarithm of the length of the left edge in the picture over the right one
  double tilt_y = 0;  // of the upper edge over the lower one
};
ViewShape shape_of(std::span<const PicturePoint> points, const Board& board, int width, int height);

// Part of the picture inside of the line around all points.
double covered_part(std::span<const View> views, int width, int height);

inline constexpr double kCoveredMin = 0.6;
inline constexpr int kAreas = 3;  // the picture is divided into 3 x 3 areas
inline constexpr double kTiltMin = 0.08;

class ViewCollector {
 public:
  ViewCollector(const Board& board, int width, int height);

  enum class Verdict : std::uint8_t {
    kTaken,
    kMoving,   // the board has moved since the last picture, which blurs it
    kSimilar,  // to a view that was taken
  };
  // The points of the next picture that shows the board.
  Verdict offer(const std::vector<PicturePoint>& points, std::string name);
  // The next picture does not show the board.
  void offer_nothing() { last_.clear(); }

  [[nodiscard]] const std::vector<View>& views() const { return views_; }
  // Without the condition that the board must not move: for pictures of files.
  void take(View view);
  // What to do with the board, for example "bring the board to the upper left"; empty: all is
  // there.
  [[nodiscard]] std::vector<std::string> missing() const;

 private:
  [[nodiscard]] bool is_still(const std::vector<PicturePoint>& points) const;
  [[nodiscard]] bool is_new(const ViewShape& shape) const;

  Board board_;
  int width_;
  int height_;
  std::vector<View> views_;
  std::vector<ViewShape> shapes_;
  std::vector<PicturePoint> last_;
  std::array<std::array<int, kAreas>, kAreas> points_in_{};  // rows, columns
};

}  // namespace rack::camera_calibrate
