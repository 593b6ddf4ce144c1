#include "tools/camera_calibrate/board_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::camera_calibrate {
namespace {

using Points = std::vector<cv::Point2f>;

constexpr int kSearchedSideMax = 1280;  // pixels; larger pictures are searched in a smaller copy

// Smallest distance of points that are neighbours in a row or a column.
double spacing_of(const Points& points, const Board& board) {
  double least = std::numeric_limits<double>::max();
  const auto columns = static_cast<std::size_t>(board.columns);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i % columns != 0) least = std::min(least, cv::norm(points[i] - points[i - 1]));
    if (i >= columns) least = std::min(least, cv::norm(points[i] - points[i - columns]));
  }
  return least;
}

bool find_corners(const cv::Mat& picture, const Board& board, Points& points) {
  const double shrunk =
      std::min(1.0, static_cast<double>(kSearchedSideMax) / std::max(picture.cols, picture.rows));
  cv::Mat searched = picture;
  if (shrunk < 1) cv::resize(picture, searched, {}, shrunk, shrunk, cv::INTER_AREA);
  if (!cv::findChessboardCorners(
          searched, {board.columns, board.rows}, points,
          cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK))
    return false;
  for (cv::Point2f& point : points) {
    const auto grown = static_cast<float>(1 / shrunk);
    point = {(point.x + 0.5F) * grown - 0.5F, (point.y + 0.5F) * grown - 0.5F};
  }
  // The area that determines a corner must not contain its neighbours.
  const int half = std::clamp(static_cast<int>(0.4 * spacing_of(points, board)), 2, 15);
  cv::cornerSubPix(picture, points, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 0.001});
  return true;
}

bool find_circles(const cv::Mat& picture, const Board& board, Points& points) {
  cv::SimpleBlobDetector::Params blobs;
  blobs.minArea = 12;
  // A circle is at most as large as the picture divided by the circles in it.
  blobs.maxArea = static_cast<float>(picture.total()) / static_cast<float>(board.points());
  blobs.maxArea = std::max(blobs.maxArea, 2 * blobs.minArea);
  blobs.minDistBetweenBlobs = 3;
  const int kind = board.kind == BoardKind::kCircles ? cv::CALIB_CB_SYMMETRIC_GRID
                                                     : cv::CALIB_CB_ASYMMETRIC_GRID;
  return cv::findCirclesGrid(picture, {board.columns, board.rows}, points, kind,
                             cv::SimpleBlobDetector::create(blobs));
}

}  // namespace

std::optional<std::vector<PicturePoint>> find_board(const GreyImage& image, const Board& board) {
  const cv::Mat picture(image.height, image.width, CV_8U,
                        const_cast<std::byte*>(image.pixels.data()));
  Points points;
  bool is_found = false;
  // An exception is about a picture in which nothing can be found, for example a tiny one.
  (void)pictures::call_opencv("finding the board", [&] {
    is_found = board.kind == BoardKind::kChessboard ? find_corners(picture, board, points)
                                                    : find_circles(picture, board, points);
  });
  if (!is_found || points.size() != board.points()) return std::nullopt;
  std::vector<PicturePoint> found;
  for (const cv::Point2f& point : points) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y)) return std::nullopt;
    found.push_back({point.x, point.y});
  }
  return found;
}

}  // namespace rack::camera_calibrate
