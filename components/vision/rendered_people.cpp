#include "components/vision/rendered_people.h"

#include <array>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace rack::vision {

namespace {

constexpr int kShift = 4;  // fractions of pixels, for cv::fillPoly()

cv::Mat pixels_of(Rendered& picture) {
  return {picture.height, picture.width, CV_8U, picture.pixels.data()};
}

// A point right of and above a place on the ground, across the line of sight.
struct Point {
  double right = 0;
  double up = 0;
};

class Board {
 public:
  Board(Rendered& picture, const CameraGeometry& camera, double x, double y)
      : pixels_(pixels_of(picture)), camera_(camera), x_(x), y_(y), angle_(std::atan2(y, x)) {}

  void polygon(std::span<const Point> corners, int grey) {
    std::vector<cv::Point> points;
    for (const Point& corner : corners) {
      const auto pixel = camera_.pixel(
          {x_ - corner.right * std::sin(angle_), y_ + corner.right * std::cos(angle_), -corner.up});
      if (!pixel) return;
      // The centre of the first pixel is half a pixel from the edge.
      points.emplace_back(static_cast<int>(std::lround((pixel->column - 0.5) * (1 << kShift))),
                          static_cast<int>(std::lround((pixel->row - 0.5) * (1 << kShift))));
    }
    cv::fillPoly(pixels_, std::vector<std::vector<cv::Point>>{points}, cv::Scalar(grey),
                 cv::LINE_AA, kShift);
  }
  void box(double left, double right, double bottom, double top, int grey) {
    polygon(
        std::array{Point{left, bottom}, Point{right, bottom}, Point{right, top}, Point{left, top}},
        grey);
  }
  void ellipse(const Point& middle, double across, double up, int grey) {
    std::vector<Point> points;
    constexpr int kCorners = 32;
    for (int i = 0; i < kCorners; ++i) {
      const double angle = 2 * kPi * i / kCorners;
      points.push_back({middle.right + across * std::cos(angle), middle.up + up * std::sin(angle)});
    }
    polygon(points, grey);
  }

 private:
  cv::Mat pixels_;
  const CameraGeometry& camera_;
  double x_;
  double y_;
  double angle_;
};

void draw_side(Board& board, double k, double side, double step, int shirt, int trousers) {
  const double foot = side * (95 + step / 2);
  board.polygon(
      std::array{Point{side * 10 * k, 900 * k}, Point{side * 175 * k, 930 * k},
                 Point{(foot + side * 60) * k, 90 * k}, Point{(foot - side * 45) * k, 90 * k}},
      trousers);
  // A shaded side.
  board.polygon(
      std::array{Point{side * 120 * k, 900 * k}, Point{side * 175 * k, 930 * k},
                 Point{(foot + side * 60) * k, 90 * k}, Point{(foot + side * 30) * k, 90 * k}},
      trousers - 12);
  board.box((foot - side * 50) * k, (foot + side * 75) * k, 0, 90 * k, 25);
  board.polygon(std::array{Point{side * 175 * k, 1440 * k}, Point{side * 235 * k, 1400 * k},
                           Point{side * 275 * k, 850 * k}, Point{side * 210 * k, 840 * k}},
                shirt - 15);
  board.ellipse({side * 243 * k, 800 * k}, 38 * k, 65 * k, 165);
}

}  // namespace

Rendered rendered_room(const CameraGeometry& camera, unsigned seed) {
  Rendered made;
  made.pixels.resize(static_cast<std::size_t>(made.width) * static_cast<std::size_t>(made.height));
  cv::Mat picture = pixels_of(made);
  constexpr double kWall = 7000;
  const double edge = camera.pixel({kWall, 0, 0}).value_or(ImagePoint{0, 300}).row;
  cv::RNG random(seed);
  // Clouds of several sizes.
  cv::Mat sum(picture.size(), CV_32F, cv::Scalar(0));
  for (const int cell : {4, 16, 64}) {
    cv::Mat grains(picture.rows / cell + 1, picture.cols / cell + 1, CV_32F);
    random.fill(grains, cv::RNG::NORMAL, 0, 7);
    cv::resize(grains, grains, picture.size(), 0, 0, cv::INTER_CUBIC);
    sum += grains;
  }
  for (int row = 0; row < picture.rows; ++row)
    for (int column = 0; column < picture.cols; ++column)
      picture.at<std::uint8_t>(row, column) = cv::saturate_cast<std::uint8_t>(
          (row < edge ? 150.0F : 105.0F) + sum.at<float>(row, column));
  return made;
}

void add_furniture(Rendered& picture, const CameraGeometry& camera) {
  Board door(picture, camera, 6900, 2000);
  door.box(-500, 500, 0, 2050, 70);
  door.box(-430, 430, 0, 1980, 110);
  Board shelf(picture, camera, 6000, -1800);
  shelf.box(-600, 600, 0, 1900, 60);
  for (int board = 0; board < 5; ++board)
    shelf.box(-560, 560, 60 + board * 370, 380 + board * 370, 95 + 15 * board);
  Board crate(picture, camera, 4000, 900);
  crate.box(-300, 300, 0, 600, 175);
  crate.box(-300, 300, 290, 310, 90);
  Board table(picture, camera, 5000, 200);
  table.box(-700, 700, 700, 740, 50);
  for (const double leg : {-650.0, 650.0}) table.box(leg - 25, leg + 25, 0, 700, 55);
  Board lamp(picture, camera, 4500, -700);
  lamp.box(-15, 15, 0, 1500, 40);
  lamp.ellipse({0, 20}, 150, 20, 40);
  lamp.polygon(std::array{Point{-90, 1750}, Point{90, 1750}, Point{180, 1450}, Point{-180, 1450}},
               210);
}

void add_person(Rendered& picture, const DrawnPerson& person, const CameraGeometry& camera) {
  Board board(picture, camera, person.x, person.y);
  const double k = person.height / 1750;  // the measures are of an adult
  const int shirt = person.is_bright ? 225 : 60;
  const int trousers = person.is_bright ? 190 : 40;
  for (const double side : {-1.0, 1.0}) draw_side(board, k, side, person.step, shirt, trousers);
  const std::array trunk = {
      Point{-175, 900}, Point{-160, 1150}, Point{-215, 1420}, Point{-150, 1475}, Point{-60, 1500},
      Point{60, 1500},  Point{150, 1475},  Point{215, 1420},  Point{160, 1150},  Point{175, 900}};
  std::vector<Point> scaled;
  for (const Point& at : trunk) scaled.push_back({at.right * k, at.up * k});
  board.polygon(scaled, shirt);
  board.box(-55 * k, 55 * k, 1480 * k, 1560 * k, 150);
  board.ellipse({0, 1630 * k}, 82 * k, 120 * k, 60);
  board.ellipse({0, 1605 * k}, 74 * k, 100 * k, 170);
}

void add_noise(Rendered& picture, double noise, double blur, unsigned seed) {
  cv::Mat pixels = pixels_of(picture);
  if (blur > 0) cv::GaussianBlur(pixels, pixels, {}, blur);
  cv::Mat grains(pixels.size(), CV_16S);
  cv::RNG random(seed);
  random.fill(grains, cv::RNG::NORMAL, 0, noise);
  cv::add(pixels, grains, pixels, cv::noArray(), CV_8U);
}

}  // namespace rack::vision
