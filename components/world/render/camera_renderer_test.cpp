// What a camera of the world sees, against the truth: places are where OpenCV projects them, people
// are as large as they are, and libapriltag finds the markers and their poses.
#include "components/world/render/camera_renderer.h"

#include <cmath>
#include <vector>

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "components/world/core/rooms_fixture.h"

namespace rack::world {
namespace camera_renderer_test {

constexpr double kFocal = 500;
constexpr double kCameraHeight = 600;

// An empty hall of 40 m, a robot in its middle that looks north, and a camera without noise.
WorldDescription hall() {
  WorldDescription hall;
  hall.ground = {{-20000, -20000}, {20000, 20000}};
  RobotDescription robot{.name = "scout", .front = 100, .back = 100, .left = 100, .right = 100};
  SensorDescription camera{.name = "camera", .kind = SensorKind::kCamera};
  camera.mount.z = -kCameraHeight;
  camera.camera.focal = kFocal;
  robot.sensors = {camera};
  hall.robots = {robot};
  return hall;
}
CameraDescription& camera_of(WorldDescription& world) { return world.robots[0].sensors[0].camera; }
Pose& mount_of(WorldDescription& world) { return world.robots[0].sensors[0].mount; }

View view_of(const WorldDescription& description) {
  const World world = made(description);
  View view;
  world.view({0, 0}, kBegin, view);
  return view;
}

cv::Mat picture_of(const WorldDescription& world, const View& view) {
  auto renderer = CameraRenderer::make(world, {0, 0});
  EXPECT_TRUE(renderer) << renderer.error().message();
  const auto bgr = (*renderer)->render(view);
  EXPECT_TRUE(bgr) << bgr.error().message();
  const CameraDescription& camera = (*renderer)->camera();
  EXPECT_EQ(bgr->size(), static_cast<std::size_t>(camera.width * camera.height * 3));
  return cv::Mat(camera.height, camera.width, CV_8UC3, const_cast<std::byte*>(bgr->data())).clone();
}
cv::Mat picture_of(const WorldDescription& world) { return picture_of(world, view_of(world)); }

// The part of the picture in which two pictures differ.
cv::Rect difference(const cv::Mat& one, const cv::Mat& other) {
  cv::Mat difference;
  cv::absdiff(one, other, difference);
  cv::cvtColor(difference, difference, cv::COLOR_BGR2GRAY);
  constexpr int kVisible = 24;
  return cv::boundingRect(difference > kVisible);
}

// Where OpenCV projects a point ahead of the camera: mm to the right, above the ground, ahead.
cv::Point2d projected(const CameraDescription& camera, double right, double height, double ahead) {
  std::vector<cv::Point2d> pixels;
  const cv::Matx33d matrix(camera.focal, 0, (camera.width - 1) / 2.0, 0, camera.focal,
                           (camera.height - 1) / 2.0, 0, 0, 1);
  cv::projectPoints(std::vector<cv::Point3d>{{right, kCameraHeight - height, ahead}},
                    cv::Vec3d::zeros(), cv::Vec3d::zeros(), matrix,
                    cv::Vec4d(camera.k1, camera.k2, 0, 0), pixels);
  return pixels.front();
}

// --- geometry

TEST(CameraRenderer, ABoxIsWhereOpenCvProjectsIt) {
  for (const double k1 : {0.0, -0.15, 0.1}) {
    WorldDescription world = hall();
    camera_of(world).k1 = k1;
    camera_of(world).k2 = -k1 / 10;
    const cv::Mat before = picture_of(world);
    // 3000 to 3500 mm ahead, 400 to 1400 mm to the right; its left side is visible.
    world.obstacles = {{.at = {3250, 900}, .length = 500, .width = 1000, .height = 900}};
    const cv::Rect box = difference(before, picture_of(world));
    const auto top_left = projected(camera_of(world), 400, 900, 3000);
    const auto bottom_right = projected(camera_of(world), 1400, 900, 3000);
    EXPECT_NEAR(box.x, projected(camera_of(world), 400, 900, 3500).x, 1.5) << k1;
    EXPECT_NEAR(box.y, std::min(top_left.y, bottom_right.y), 1.5) << k1;
    EXPECT_NEAR(box.x + box.width - 1, bottom_right.x, 1.5) << k1;
  }
}

TEST(CameraRenderer, PeopleAreAsTallAsTheyAre) {
  WorldDescription world = hall();
  View view = view_of(world);
  const cv::Mat empty = picture_of(world, view);
  for (const double ahead : {3000.0, 6000.0, 12000.0}) {
    view.people = {Figure{.at = {ahead, 500}, .rho = kPi}};
    const cv::Rect person = difference(empty, picture_of(world, view));
    const double top = projected(camera_of(world), 500, 1700, ahead).y;
    const double feet = projected(camera_of(world), 500, 0, ahead).y;
    const double middle = projected(camera_of(world), 500, 0, ahead).x;
    const double pixels_of_mm = kFocal / ahead;
    EXPECT_NEAR(person.y, top, 2 + 30 * pixels_of_mm) << ahead;
    EXPECT_NEAR(person.y + person.height, feet, 2 + 150 * pixels_of_mm) << ahead;
    EXPECT_NEAR(person.x + person.width / 2.0, middle, 2 + 60 * pixels_of_mm) << ahead;
    EXPECT_NEAR(person.width, 560 * pixels_of_mm, 3 + 150 * pixels_of_mm) << ahead;
  }
}

TEST(CameraRenderer, WhatIsNearerHidesWhatIsBehindIt) {
  WorldDescription world = hall();
  world.walls = {{.from = {4000, -9000}, .to = {4000, 9000}, .height = 3000}};
  View view = view_of(world);
  const cv::Mat wall = picture_of(world, view);
  view.people = {Figure{.at = {5000, 0}}};
  EXPECT_TRUE(difference(wall, picture_of(world, view)).empty()) << "behind the wall";
  view.people = {Figure{.at = {3000, 0}}};
  EXPECT_FALSE(difference(wall, picture_of(world, view)).empty());
  view.people = {Figure{.at = {-3000, 0}}};
  EXPECT_TRUE(difference(wall, picture_of(world, view)).empty()) << "behind the camera";
}

// A camera that is tilted by as much as a box is turned about it sees the same box.
TEST(CameraRenderer, TurnsWithItsRobotAndItsMount) {
  WorldDescription world = hall();
  world.obstacles = {{.shape = Shape::kCircle, .at = {4000, 0}, .radius = 300, .height = 1200}};
  const auto middle_of = [&] {
    WorldDescription empty = world;
    empty.obstacles.clear();
    const cv::Rect box = difference(picture_of(empty), picture_of(world));
    return cv::Point2d(box.x + box.width / 2.0, box.y + box.height / 2.0);
  };
  const cv::Point2d straight = middle_of();
  EXPECT_NEAR(straight.x, 319.5, 2);
  mount_of(world).rho = radians(10);
  EXPECT_NEAR(middle_of().x, 319.5 - kFocal * std::tan(radians(10)), 3) << "right: it moves left";
  mount_of(world) = {.z = -kCameraHeight, .psi = radians(10)};
  EXPECT_GT(middle_of().y, straight.y + 70) << "up: it moves down";
  mount_of(world) = {.z = -kCameraHeight};
  world.robots[0].start.rho = radians(-10);
  EXPECT_NEAR(middle_of().x, 319.5 + kFocal * std::tan(radians(10)), 3);
}

// --- pixels

TEST(CameraRenderer, NoiseFollowsFromTheTimeAndHasItsDeviation) {
  WorldDescription world = hall();
  const cv::Mat clean = picture_of(world);
  EXPECT_EQ(cv::norm(clean, picture_of(world), cv::NORM_INF), 0);
  world.robots[0].sensors[0].noise.pixel = 5;
  View view = view_of(world);
  const cv::Mat noisy = picture_of(world, view);
  EXPECT_EQ(cv::norm(noisy, picture_of(world, view), cv::NORM_INF), 0);
  cv::Mat difference;
  cv::subtract(noisy, clean, difference, cv::noArray(), CV_16SC3);
  // The ground is neither black nor white.
  const cv::Mat ground = difference.rowRange(300, 480);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(ground, mean, deviation);
  EXPECT_NEAR(mean[0], 0, 0.1);
  EXPECT_NEAR(deviation[0], 5, 0.2);
  view.age += std::chrono::milliseconds(5);
  EXPECT_GT(cv::norm(noisy, picture_of(world, view), cv::NORM_INF), 5) << "other noise later";
}

// Cameras in walls, above each other, upside down; very large and very small things.
TEST(CameraRenderer, RendersAnyWorld) {
  Random random(7);
  const auto any = [&](double from, double to) {
    return static_cast<double>(random.uniform(static_cast<float>(from), static_cast<float>(to)));
  };
  for (int run = 0; run < 60; ++run) {
    WorldDescription world = hall();
    camera_of(world).width = static_cast<int>(any(16, 200));
    camera_of(world).height = static_cast<int>(any(16, 200));
    camera_of(world).focal = any(100, 300);
    world.ceiling = run % 2 == 0 ? 2500 : 0;
    View view = view_of(world);
    for (int i = 0; i < 20; ++i) {
      const double far = std::pow(10, any(0, 7));
      const auto place = [&] { return MapPoint{any(-far, far), any(-far, far)}; };
      world.walls.push_back({.from = place(), .to = i == 0 ? MapPoint{} : place(), .height = far});
      world.obstacles.push_back({.shape = i % 2 == 0 ? Shape::kBox : Shape::kCircle,
                                 .at = place(),
                                 .length = any(1, far),
                                 .width = 1,
                                 .radius = any(1, far),
                                 .height = far});
      view.people.push_back({.at = place(), .rho = any(-9, 9), .gait = any(0, 100)});
      world.markers.push_back(
          {.id = i * 100, .at = place(), .rho = any(-9, 9), .height = 500, .size = any(1, far)});
    }
    world.walls.push_back({.from = {-1000, 0}, .to = {1000, 0}});
    view.robots = {{0, Box::of({0, 0}, 0, 100, 100)}};
    view.turn = {{{0, 0, -1}, {0, 1, 0}, {1, 0, 0}}};
    (void)picture_of(world, view);
  }
}

// --- markers

struct FoundMarker {
  int id = -1;
  cv::Point3d at{};  // mm: right, down, ahead
  cv::Vec3d face{};  // the direction that it faces, in the frame of the camera
};

// By libapriltag, as a component does it: in the picture without the distortion of the lens.
std::vector<FoundMarker> found_in(const cv::Mat& picture, const CameraDescription& camera,
                                  double size) {
  const cv::Matx33d matrix(camera.focal, 0, (camera.width - 1) / 2.0, 0, camera.focal,
                           (camera.height - 1) / 2.0, 0, 0, 1);
  cv::Mat grey;
  cv::Mat straight;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::undistort(grey, straight, matrix, cv::Vec4d(camera.k1, camera.k2, 0, 0));
  image_u8_t image{.width = straight.cols,
                   .height = straight.rows,
                   .stride = straight.cols,
                   .buf = straight.data};
  apriltag_family_t* const family = tag36h11_create();
  apriltag_detector_t* const detector = apriltag_detector_create();
  apriltag_detector_add_family(detector, family);
  detector->quad_decimate = 1;
  zarray_t* const all = apriltag_detector_detect(detector, &image);
  std::vector<FoundMarker> found;
  for (int i = 0; i < zarray_size(all); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(all, i, &detection);
    // Its corners, from the lower left one against the clock; its first pixel begins at 0.
    const double half = size / 2;
    const std::vector<cv::Point3d> corners = {
        {-half, half, 0}, {half, half, 0}, {half, -half, 0}, {-half, -half, 0}};
    std::vector<cv::Point2d> pixels;
    for (const auto& corner : detection->p) pixels.emplace_back(corner[0] - 0.5, corner[1] - 0.5);
    cv::Vec3d turn;
    cv::Vec3d at;
    EXPECT_TRUE(
        cv::solvePnP(corners, pixels, matrix, cv::noArray(), turn, at, false, cv::SOLVEPNP_IPPE));
    cv::Matx33d rotation;
    cv::Rodrigues(turn, rotation);
    const FoundMarker marker{.id = detection->id,
                             .at = {at[0], at[1], at[2]},
                             .face = {-rotation(0, 2), -rotation(1, 2), -rotation(2, 2)}};
    found.push_back(marker);
  }
  apriltag_detections_destroy(all);
  apriltag_detector_destroy(detector);
  tag36h11_destroy(family);
  return found;
}

struct MarkerCase {
  double ahead;
  double right;
  double turned;  // degrees, of its face from the direction towards the camera
  double k1;
};

class RenderedMarker : public testing::TestWithParam<MarkerCase> {};

// Within 1.5 % of its distance, and 6 degrees of its direction.
TEST_P(RenderedMarker, IsFoundWhereItIs) {
  const MarkerCase& is = GetParam();
  constexpr double kSize = 200;
  WorldDescription world = hall();
  camera_of(world).k1 = is.k1;
  world.robots[0].sensors[0].noise.pixel = 3;
  world.walls = {{.from = {9000, -9000}, .to = {9000, 9000}}};
  const double face = kPi + radians(is.turned);
  world.markers = {
      {.id = 17, .at = {is.ahead, is.right}, .rho = face, .height = 800, .size = kSize}};
  const auto found = found_in(picture_of(world), camera_of(world), kSize);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].id, 17);
  const double distance = std::hypot(is.ahead, is.right);
  const double near = 0.015 * distance;
  EXPECT_NEAR(found[0].at.x, is.right, near);
  EXPECT_NEAR(found[0].at.y, kCameraHeight - 800, near);
  EXPECT_NEAR(found[0].at.z, is.ahead, near);
  // x of the world is ahead, y to the right.
  const double seen = std::atan2(found[0].face[0], found[0].face[2]);
  EXPECT_NEAR(degrees(signed_angle(seen - face)), 0, 6);
}

INSTANTIATE_TEST_SUITE_P(All, RenderedMarker,
                         testing::Values(MarkerCase{1000, 0, 0, 0}, MarkerCase{2000, 300, 30, 0},
                                         MarkerCase{2000, -500, -50, 0},
                                         MarkerCase{4000, 1200, 20, 0},
                                         MarkerCase{2000, 700, 30, -0.15},
                                         MarkerCase{3000, -1200, -25, 0.1}));

// From behind it is a wall's back: nothing.
TEST(RenderedMarkerSides, HaveOnlyOneFace) {
  WorldDescription world = hall();
  world.markers = {{.id = 17, .at = {1500, 0}, .height = 600, .size = 200}};
  EXPECT_TRUE(found_in(picture_of(world), camera_of(world), 200).empty());
  world.markers[0].rho = kPi;
  EXPECT_EQ(found_in(picture_of(world), camera_of(world), 200).size(), 1U);
  world.markers[0].id = 587;  // of 0 to 586
  EXPECT_TRUE(found_in(picture_of(world), camera_of(world), 200).empty());
}

}  // namespace camera_renderer_test
}  // namespace rack::world
