#include "components/world/render/camera_renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "components/geometry/pose.h"
#include "components/pictures/opencv_call.h"
#include "components/world/core/noise.h"
#include "components/world/render/artist.h"
#include "components/world/render/lens.h"
#include "components/world/render/marker_paint.h"
#include "components/world/render/materials.h"
#include "components/world/render/pedestrian.h"
#include "components/world/render/pixel_noise.h"

namespace rack::world {

namespace {

constexpr double kHorizon = 300e3;  // mm: how far the ground is drawn

// Where a plane is drawn from, so that its texture stays in place: a whole number of repetitions
// away from the origin.
double repeated(double at, double repetition) { return std::floor(at / repetition) * repetition; }

}  // namespace

class CameraRenderer::Studio {
 public:
  Studio(const WorldDescription& world, const SensorId& sensor)
      : world_(world),
        camera_(world.robots[sensor.robot].sensors[sensor.sensor].camera),
        lens_(camera_),
        raster_(lens_.width(), lens_.height(), camera_.focal, lens_.cx(), lens_.cy()),
        materials_(world.ceiling > 0),
        markers_(world.markers),
        noise_(camera_.width * 3, camera_.height,
               world.robots[sensor.robot].sensors[sensor.sensor].noise.pixel,
               stirred(world.seed, 5000 + sensor.robot * 100 + sensor.sensor)),
        bgr_(static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height) *
             3) {}

  [[nodiscard]] const CameraDescription& camera() const { return camera_; }

  // Near objects first, as those behind them then cost less. Shadows last: they darken the ground.
  std::span<const std::uint8_t> render(const View& view) {
    raster_.clear();
    Artist artist(raster_, view);
    draw_bodies(artist, view);
    markers_.draw(artist);
    draw_walls(artist);
    draw_ground(artist, view);
    draw_shadows(artist, view);
    lens_.apply(raster_.pixels(), bgr_);
    noise_.add(bgr_, view.age);
    return bgr_;
  }

 private:
  // A wall and its distance from the camera.
  struct Near {
    double distance = 0;
    std::size_t number = 0;
  };

  void draw_bodies(Artist& artist, const View& view) {
    for (std::size_t i = 0; i < view.people.size(); ++i)
      pedestrians_.draw(artist, i, view.people[i], world_.people.height);
    for (const SeenRobot& robot : view.robots) draw_robot(artist, robot);
    for (const ObstacleDescription& obstacle : view.obstacles) draw_obstacle(artist, obstacle);
    for (const ObstacleDescription& obstacle : world_.obstacles) draw_obstacle(artist, obstacle);
  }

  // A hull on four wheels.
  void draw_robot(Artist& artist, const SeenRobot& robot) {
    constexpr double kClearance = 0.2;  // share of its height
    const double height = world_.robots[robot.id].height;
    const Box& hull = robot.hull;
    artist.box(hull, kClearance * height, height, materials_.robot);
    Box wheel = hull;
    wheel.half_length = std::min(hull.half_length, height * 0.5) * 0.5;
    wheel.half_width = hull.half_width * 0.1;
    for (const double ahead : {-0.6, 0.6})
      for (const double right : {-1.0, 1.0}) {
        const double x = ahead * hull.half_length;
        const double y = right * hull.half_width;
        wheel.at = {hull.at.x + x * hull.c - y * hull.s, hull.at.y + x * hull.s + y * hull.c};
        artist.box(wheel, 0, 2 * wheel.half_length, materials_.wheel);
      }
  }

  void draw_obstacle(Artist& artist, const ObstacleDescription& obstacle) {
    if (obstacle.shape == Shape::kCircle)
      return artist.cylinder(obstacle.at, obstacle.radius, obstacle.height, materials_.barrel);
    artist.box(Box::of(obstacle.at, obstacle.rho, obstacle.length, obstacle.width), 0,
               obstacle.height, materials_.crate);
  }

  void draw_walls(Artist& artist) {
    order_.clear();
    for (std::size_t i = 0; i < world_.walls.size(); ++i) {
      const WallDescription& wall = world_.walls[i];
      order_.push_back({std::min(artist.distance_to(wall.from), artist.distance_to(wall.to)), i});
    }
    std::ranges::sort(order_, {}, &Near::distance);
    for (const Near& near : order_) draw_wall(artist, near.number);
  }

  void draw_wall(Artist& artist, std::size_t number) {
    const WallDescription& wall = world_.walls[number];
    const double x = wall.to.x - wall.from.x;
    const double y = wall.to.y - wall.from.y;
    const double length = std::hypot(x, y);
    if (length <= 0) return;
    const double end = length / Materials::kWallPixel;
    const double top = wall.height / Materials::kWallPixel;
    // Both sides of a wall are lit alike.
    constexpr double kUneven = 0.05;
    const double own = static_cast<double>(Random(number).uniform(-1, 1)) * kUneven;
    const double light = (std::abs(x) > std::abs(y) ? 0.98 : 0.84) + own;
    artist.polygon(
        std::array{Artist::Spot{Artist::point(wall.from, wall.height), 0, top},
                   Artist::Spot{Artist::point(wall.to, wall.height), end, top},
                   Artist::Spot{Artist::point(wall.to, 0), end, 0},
                   Artist::Spot{Artist::point(wall.from, 0), 0, 0}},
        light,
        {.texture = &materials_.walls.at(number % materials_.walls.size()), .both_sides = true});
  }

  void draw_ground(Artist& artist, const View& view) {
    draw_plane(artist, view, 0, materials_.ground);
    if (world_.ceiling > 0) return draw_plane(artist, view, world_.ceiling, materials_.ceiling);
    draw_sky(artist, view);
  }

  void draw_plane(Artist& artist, const View& view, double height, const Texture& texture) {
    constexpr double kRepetition = Materials::kSide * Materials::kGroundPixel;
    const double x = repeated(view.from[0], kRepetition);
    const double y = repeated(view.from[1], kRepetition);
    const double far = kHorizon / Materials::kGroundPixel;
    const auto spot = [&](double north, double east) {
      return Artist::Spot{Artist::point({x + north * kHorizon, y + east * kHorizon}, height),
                          east * far, north * far};
    };
    artist.polygon(std::array{spot(1, -1), spot(1, 1), spot(-1, 1), spot(-1, -1)}, 1,
                   {.texture = &texture, .both_sides = true});
  }

  // A wide tube around the camera.
  void draw_sky(Artist& artist, const View& view) {
    const MapPoint here{view.from[0], view.from[1]};
    constexpr std::array kCorners = {MapPoint{1, 1}, MapPoint{1, -1}, MapPoint{-1, -1},
                                     MapPoint{-1, 1}};
    const double height = -view.from[2];
    for (std::size_t i = 0; i < kCorners.size(); ++i) {
      const auto spot = [&](const MapPoint& corner, double up, double light) {
        return Artist::Spot{
            Artist::point({here.x + corner.x * kHorizon, here.y + corner.y * kHorizon},
                          height + up * kHorizon),
            0, 0, light};
      };
      const MapPoint& left = kCorners.at(i);
      const MapPoint& right = kCorners.at((i + 1) % kCorners.size());
      // Its height as a share of its distance, and its brightness: brighter near the horizon.
      constexpr std::array kLevels = {std::pair{-0.01, 1.45}, std::pair{0.05, 1.3},
                                      std::pair{0.4, 1.0}, std::pair{20.0, 0.9}};
      for (std::size_t k = 0; k + 1 < kLevels.size(); ++k) {
        const auto& [low, bright] = kLevels.at(k);
        const auto& [high, dark] = kLevels.at(k + 1);
        artist.polygon(std::array{spot(left, high, dark), spot(right, high, dark),
                                  spot(right, low, bright), spot(left, low, bright)},
                       1, {.texture = &materials_.sky, .both_sides = true});
      }
    }
  }

  void draw_shadows(Artist& artist, const View& view) {
    constexpr double kPerson = 330;  // mm
    constexpr double kAround = 1.25;
    for (const Figure& person : view.people) artist.shadow(person.at, person.rho, kPerson, kPerson);
    const auto below = [&](const Box& box) {
      artist.shadow(box.at, std::atan2(box.s, box.c), kAround * 1.2 * box.half_length,
                    kAround * 1.2 * box.half_width);
    };
    for (const SeenRobot& robot : view.robots) below(robot.hull);
    const auto below_obstacle = [&](const ObstacleDescription& obstacle) {
      if (obstacle.shape == Shape::kBox)
        below(Box::of(obstacle.at, obstacle.rho, obstacle.length, obstacle.width));
      else
        artist.shadow(obstacle.at, 0, kAround * obstacle.radius, kAround * obstacle.radius);
    };
    for (const ObstacleDescription& obstacle : view.obstacles) below_obstacle(obstacle);
    for (const ObstacleDescription& obstacle : world_.obstacles) below_obstacle(obstacle);
  }

  WorldDescription world_;
  CameraDescription camera_;
  Lens lens_;
  Raster raster_;
  Materials materials_;
  MarkerPaint markers_;
  Pedestrians pedestrians_;
  PixelNoise noise_;
  std::vector<std::uint8_t> bgr_;
  std::vector<Near> order_;
};

CameraRenderer::CameraRenderer(std::unique_ptr<Studio> studio) : studio_(std::move(studio)) {}
CameraRenderer::~CameraRenderer() = default;

tims::Result<std::unique_ptr<CameraRenderer>> CameraRenderer::make(const WorldDescription& world,
                                                                   const SensorId& sensor) {
  std::unique_ptr<Studio> studio;
  const auto made = pictures::call_opencv(
      "preparing a camera", [&] { studio = std::make_unique<Studio>(world, sensor); });
  if (!made) return made.error();
  return std::unique_ptr<CameraRenderer>(new CameraRenderer(std::move(studio)));
}

const CameraDescription& CameraRenderer::camera() const { return studio_->camera(); }

tims::Result<std::span<const std::byte>> CameraRenderer::render(const View& view) {
  std::span<const std::byte> picture;
  const auto done =
      pictures::call_opencv("rendering", [&] { picture = std::as_bytes(studio_->render(view)); });
  if (!done) return done.error();
  return picture;
}

}  // namespace rack::world
