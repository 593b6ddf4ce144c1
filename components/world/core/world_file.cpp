#include "components/world/core/world_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/renamed_keys.h"
#include "components/geometry/pose.h"
#include "components/world/core/camera_lens.h"

namespace rack::world {

namespace {

using Node = tims::base::TomlNode;
using Reader = tims::base::TomlReader;

// mm, mm/s, mm/s2
constexpr double kFarthest = 1e7;
constexpr double kLargest = 1e6;
constexpr double kFastest = 1e5;

struct Range {
  double min;
  double max;
};

template <typename T>
struct Name {
  std::string_view name;
  T value;
};

constexpr std::array<Name<DriveKind>, 3> kDrives = {
    {{"differential", DriveKind::kDifferential},
     {"ackermann", DriveKind::kAckermann},
     {"double-ackermann", DriveKind::kDoubleAckermann}}};
constexpr std::array<Name<SensorKind>, 6> kSensors = {{{"scanner", SensorKind::kScanner},
                                                       {"scanner3d", SensorKind::kScanner3d},
                                                       {"satellite", SensorKind::kSatellite},
                                                       {"inertial", SensorKind::kInertial},
                                                       {"compass", SensorKind::kCompass},
                                                       {"camera", SensorKind::kCamera}}};

constexpr std::array<Name<TurnedAbout>, 3> kAxes = {
    {{"roll", TurnedAbout::kRoll}, {"pitch", TurnedAbout::kPitch}, {"yaw", TurnedAbout::kYaw}}};

class WorldReader {
 public:
  WorldReader(const ReadPlan& read_plan, const DecodePicture& decode)
      : read_plan_(read_plan), decode_(decode) {}

  WorldFile read(const tims::base::TextFile& text) {
    tims::base::TomlTree tree = tims::base::parse_toml(text);
    file_.hints = tims::base::rename_former_keys(tree);
    for (const auto& problem : tree.problems) reader_.add(problem);
    WorldDescription& world = file_.description;
    bool has_ground = false;
    reader_.table(tree.root, "a world",
                  {{"name", [&](const Node& n) { reader_.text(n, world.name); }},
                   {"seed", [&](const Node& n) { seed(n); }},
                   {"ground",
                    [&](const Node& n) {
                      has_ground = true;
                      area(n, "[ground]", world.ground);
                    }},
                   {"origin", [&](const Node& n) { origin(n); }},
                   {"ceiling", size(world.ceiling)},
                   {"markers", [&](const Node& n) { markers(n); }},
                   {"plan", each([&](const Node& n) { plan(n); })},
                   {"wall", each([&](const Node& n) { wall(n); })},
                   {"obstacle", each([&](const Node& n) { obstacle(n); })},
                   {"people", [&](const Node& n) { people(n); }},
                   {"robot", each([&](const Node& n) { robot(n); })}});
    if (!has_ground) fit_ground();
    file_.problems = reader_.problems();
    return std::move(file_);
  }

 private:
  using Read = Reader::Read;

  Read each(Read read) {
    return [this, read = std::move(read)](const Node& node) { reader_.tables(node, read); };
  }
  // Bounds are template parameters, so that a Read holds two pointers and needs no allocation.
  template <Range kRange>
  Read real(double& out) {
    return [this, &out](const Node& node) { reader_.real(node, kRange.min, kRange.max, out); };
  }
  Read size(double& out) { return real<Range{1, kLargest}>(out); }
  Read rate(double& out) { return real<Range{0, kFastest}>(out); }
  Read share(double& out) { return real<Range{0, 1}>(out); }
  template <int kMost>
  Read angle(double& out) {
    return [this, &out](const Node& node) {
      double value = degrees(out);
      reader_.real(node, -kMost, kMost, value);
      out = radians(value);
    };
  }
  Read text(std::string& out) {
    return [this, &out](const Node& node) { reader_.text(node, out); };
  }
  Read duration(tims::Duration& out) {
    return [this, &out](const Node& node) { reader_.duration(node, true, out); };
  }
  template <typename T, std::size_t N>
  Read one_of(const std::array<Name<T>, N>& names, std::string_view what, T& out) {
    return [this, &names, what, &out](const Node& node) {
      std::string value;
      if (!reader_.text(node, value)) return;
      const auto found = std::ranges::find(names, value, &Name<T>::name);
      if (found != names.end()) {
        out = found->value;
        return;
      }
      std::vector<std::string> known;
      known.reserve(N);
      for (const auto& name : names) known.emplace_back(name.name);
      reader_.unknown(node.at_value, what, value, known);
    };
  }

  // [1, 2.5]
  void numbers(const Node& node, std::string_view what, std::span<double> out) {
    if (node.form != Node::Form::kArray || node.children.size() != out.size())
      return reader_.refuse(
          node, fmt::format("{} must be {}", node.key.empty() ? "an item" : node.key, what));
    for (std::size_t i = 0; i < out.size(); ++i)
      reader_.real(node.children[i], -kFarthest, kFarthest, out[i]);
  }
  Read point(MapPoint& out) {
    return [this, &out](const Node& node) {
      std::array<double, 2> value{};
      numbers(node, "a place such as [1000, -500]: mm to the north, mm to the east", value);
      out = {value[0], value[1]};
    };
  }
  Read pose(std::string_view what, Pose& out) {
    return [this, what, &out](const Node& node) {
      std::array<double, 3> value{};
      numbers(node, what, value);
      out.x = value[0];
      out.y = value[1];
      out.rho = radians(value[2]);
    };
  }

  // Reports a missing key.
  void require(const Node& node, std::string_view key) {
    const auto has = [&](const Node& child) { return child.key == key; };
    if (std::ranges::none_of(node.children, has))
      reader_.add({node.at_key, fmt::format("{} is missing", key)});
  }
  template <typename List>
  bool has_room(const Node& node, const List& list, std::size_t most, std::string_view what) {
    if (list.size() < most) return true;
    if (list.size() == most && !std::exchange(value_full_, true))
      reader_.add({node.at_key, fmt::format("more than {} {}", most, what)});
    return false;
  }

  void seed(const Node& node) {
    std::int64_t value = 1;
    reader_.number(node, 0, std::numeric_limits<std::int64_t>::max(), value);
    file_.description.seed = static_cast<std::uint64_t>(value);
  }

  void area(const Node& node, std::string_view what, Area& out) {
    reader_.table(node, what, {{"from", point(out.from)}, {"to", point(out.to)}});
    check_area(node, out);
  }
  void check_area(const Node& node, const Area& area) {
    if (!(area.from.x < area.to.x) || !(area.from.y < area.to.y))
      reader_.add({node.at_key,
                   "from must be the corner with the smaller numbers, and to the "
                   "one with the larger"});
  }

  void origin(const Node& node) {
    Origin& origin = file_.description.origin;
    reader_.table(node, "[origin]",
                  {{"latitude", angle<80>(origin.latitude)},
                   {"longitude", angle<180>(origin.longitude)},
                   {"altitude", real<Range{-1000, 10000}>(origin.altitude)}});
  }

  void plan(const Node& node) {
    std::string name;
    const Node* place = &node;
    PlanPlacement placement;
    const Node* placed = nullptr;
    double height = 2500;
    const auto of_drawing = [&](Read read) {
      return [&, read = std::move(read)](const Node& n) {
        placed = &n;
        read(n);
      };
    };
    MapPoint offset;
    reader_.table(node, "[[plan]]",
                  {{"file",
                    [&](const Node& n) {
                      reader_.text(n, name);
                      place = &n;
                    }},
                   {"scale", of_drawing(real<Range{0, 1e6}>(placement.scale))},
                   {"offset", of_drawing(point(offset))},
                   {"layers", of_drawing(text(placement.layers))},
                   {"height", size(height)}});
    require(node, "file");
    if (name.empty()) return;
    if (placed != nullptr && localisation::is_ros_map(name))
      return reader_.refuse(*placed,
                            fmt::format("a map of ROS has no {}: its .yaml file states its "
                                        "resolution and origin",
                                        placed->key));
    placement.offset_x = offset.x;
    placement.offset_y = offset.y;
    const auto read_file = [&](const std::string& file) -> tims::Result<std::string> {
      auto text = read_plan_(file);
      if (text) return text;
      return tims::Error(text.error().code(), file + ": " + text.error().detail());
    };
    auto plan = localisation::read_floor_plan(name, placement, {read_file, decode_});
    if (!plan) return reader_.refuse(*place, plan.error().detail());
    auto lines = localisation::lines_of(std::move(*plan));
    if (!lines) return reader_.refuse(*place, lines.error().detail());
    std::ranges::move(lines->drawing.remarks, std::back_inserter(file_.remarks));
    add_walls(FloorMap(*lines), height, *place);
  }

  void add_walls(const FloorMap& map, double height, const Node& place) {
    for (const FloorMap::Wall& wall : map.walls()) {
      const MapPoint to{wall.from.x + wall.extent.x, wall.from.y + wall.extent.y};
      const double farthest =
          std::max({std::abs(wall.from.x), std::abs(wall.from.y), std::abs(to.x), std::abs(to.y)});
      if (farthest > kFarthest)
        return reader_.refuse(place, fmt::format("has walls {:.0f} m away; scale is mm for each "
                                                 "unit of the drawing, offset is in its units",
                                                 farthest / 1000));
      file_.description.walls.push_back({wall.from, to, height});
    }
  }

  void markers(const Node& node) {
    std::string name;
    if (!reader_.text(node, name)) return;
    auto text = read_plan_(name);
    if (!text) return reader_.refuse(node, fmt::format("{}: {}", name, text.error().detail()));
    vision::MarkerFile file = vision::read_marker_map({name, std::move(*text)});
    for (const auto& problem : file.problems) reader_.add(problem);
    file_.description.markers = std::move(file.markers);
  }

  void wall(const Node& node) {
    WallDescription wall;
    reader_.table(
        node, "[[wall]]",
        {{"from", point(wall.from)}, {"to", point(wall.to)}, {"height", size(wall.height)}});
    require(node, "from");
    require(node, "to");
    if (has_room(node, file_.description.walls, DxfDrawing::kLinesMax, "walls"))
      file_.description.walls.push_back(wall);
  }

  void obstacle(const Node& node) {
    ObstacleDescription obstacle;
    const auto circle = [&](const Node& n) {
      obstacle.shape = Shape::kCircle;
      reader_.real(n, 1, kLargest, obstacle.radius);
    };
    reader_.table(node, "[[obstacle]]",
                  {{"at", point(obstacle.at)},
                   {"rho", angle<360>(obstacle.rho)},
                   {"length", size(obstacle.length)},
                   {"width", size(obstacle.width)},
                   {"radius", circle},
                   {"height", size(obstacle.height)}});
    require(node, "at");
    const auto is_of_box = [](const Node& n) { return n.key == "length" || n.key == "width"; };
    if (obstacle.shape == Shape::kCircle && std::ranges::any_of(node.children, is_of_box))
      reader_.add({node.at_key, "an obstacle has a radius, or a length and a width"});
    if (has_room(node, file_.description.obstacles, kObstaclesMax, "obstacles"))
      file_.description.obstacles.push_back(obstacle);
  }

  void people(const Node& node) {
    PeopleDescription& people = file_.description.people;
    std::int64_t count = 0;
    Area where = file_.description.ground;
    bool has_area = false;
    const auto corner = [&](MapPoint& out) {
      return [&, read = point(out)](const Node& n) {
        has_area = true;
        read(n);
      };
    };
    reader_.table(node, "[people]",
                  {{"count", [&](const Node& n) { reader_.number(n, 0, kPeopleMax, count); }},
                   {"walk", each([&](const Node& n) { walk(n, people.walks); })},
                   {"speed", real<Range{100, 5000}>(people.speed)},
                   {"height", real<Range{500, 2500}>(people.height)},
                   {"pause", duration(people.pause_max)},
                   {"avoids", share(people.avoids_share)},
                   {"from", corner(where.from)},
                   {"to", corner(where.to)}});
    people.count = static_cast<std::size_t>(count);
    if (!has_area) return;
    require(node, "from");
    require(node, "to");
    check_area(node, where);
    people.area = where;
  }

  void walk(const Node& node, std::vector<WalkDescription>& walks) {
    WalkDescription walk;
    const auto places = [&](const Node& n) {
      if (n.form != Node::Form::kArray || n.children.size() < 2 ||
          n.children.size() > kWalkPlacesMax)
        return reader_.refuse(n, fmt::format("places must contain 2 to {} of them such as [[0, 0], "
                                             "[1000, -500]]: mm to the north, mm to the east",
                                             kWalkPlacesMax));
      walk.places.resize(n.children.size());
      for (std::size_t i = 0; i < n.children.size(); ++i) point(walk.places[i])(n.children[i]);
    };
    reader_.table(node, "[[people.walk]]", {{"places", places}, {"pause", duration(walk.pause)}});
    require(node, "places");
    if (has_room(node, walks, kWalksMax, "walks")) walks.push_back(std::move(walk));
  }

  void slip(const Node& node, SlipDescription& slip) {
    reader_.table(node, "slip",
                  {{"distance", real<Range{-0.5, 0.5}>(slip.distance)},
                   {"turn", real<Range{-0.5, 0.5}>(slip.turn)},
                   {"distance_noise", real<Range{0, 1000}>(slip.distance_noise)},
                   {"turn_noise", angle<45>(slip.turn_noise)}});
  }

  void robot(const Node& node) {
    RobotDescription robot;
    const Node* sensors = nullptr;
    reader_.table(
        node, "[[robot]]",
        {{"name", text(robot.name)},
         {"kind", one_of(kDrives, "kind of robot", robot.kind)},
         {"at", pose("a pose such as [1000, -500, 90]: mm to the north, mm to the east, degrees "
                     "clockwise",
                     robot.start)},
         {"track", size(robot.track)},
         {"base", size(robot.base)},
         {"steer_max", angle<80>(robot.steer_max)},
         {"wheel_radius", size(robot.wheel_radius)},
         {"gear_ratio", real<Range{1e-3, 1e4}>(robot.gear_ratio)},
         {"steer_ratio", real<Range{1e-3, 1e4}>(robot.steer_ratio)},
         {"front", real<Range{0, 1e5}>(robot.front)},
         {"back", real<Range{0, 1e5}>(robot.back)},
         {"left", real<Range{0, 1e5}>(robot.left)},
         {"right", real<Range{0, 1e5}>(robot.right)},
         {"height", size(robot.height)},
         {"acceleration", rate(robot.acceleration)},
         {"deceleration", rate(robot.deceleration)},
         {"steering_rate", angle<3600>(robot.steering_rate)},
         {"lag", duration(robot.lag)},
         {"slip", [&](const Node& n) { slip(n, robot.slip); }},
         {"device", text(robot.device)},
         {"line", text(robot.line)},
         {"sensor", [&](const Node& n) { sensors = &n; }}});
    require(node, "name");
    require(node, "at");
    check_robot(node, robot);
    if (sensors != nullptr)
      reader_.tables(*sensors, [&](const Node& n) { sensor(n, robot.sensors); });
    if (has_room(node, file_.description.robots, kRobotsMax, "robots"))
      file_.description.robots.push_back(std::move(robot));
  }

  void check_robot(const Node& node, const RobotDescription& robot) {
    const auto& robots = file_.description.robots;
    if (std::ranges::find(robots, robot.name, &RobotDescription::name) != robots.end())
      reader_.add({node.at_key, fmt::format("there is another robot {}", robot.name)});
    if (robot.front + robot.back < 1 || robot.left + robot.right < 1)
      reader_.add(
          {node.at_key, "a robot is at least 1 mm long and wide: front, back, left, right"});
    if (robot.steer_max <= 0) reader_.add({node.at_key, "steer_max must be above 0"});
    if (robot.steering_rate < 0) reader_.add({node.at_key, "steering_rate must be 0 or more"});
  }

  void noise(const Node& node, NoiseDescription& noise) {
    reader_.table(node, "noise",
                  {{"range", real<Range{0, 1e4}>(noise.range)},
                   {"short", share(noise.short_share)},
                   {"dropped", share(noise.dropped_share)},
                   {"position", real<Range{0, 1e6}>(noise.position)},
                   {"drift", real<Range{0, 1e6}>(noise.drift)},
                   {"angle", angle<180>(noise.angle)},
                   {"rate", angle<360>(noise.rate)},
                   {"rate_bias", angle<360>(noise.rate_bias)},
                   {"acceleration", real<Range{0, 1e5}>(noise.acceleration)},
                   {"pixel", real<Range{0, 100}>(noise.pixel)}});
  }

  void sensor(const Node& node, std::vector<SensorDescription>& sensors) {
    SensorDescription sensor;
    double height = 0;
    const auto tilt = [&](const Node& n) {
      std::array<double, 2> value{};
      numbers(n, "two angles such as [0, -10]: degrees rolled to the right, degrees looking up",
              value);
      sensor.mount.phi = radians(value[0]);
      sensor.mount.psi = radians(value[1]);
    };
    CameraKeys camera;
    reader_.table(
        node, "[[robot.sensor]]",
        {{"name", text(sensor.name)},
         {"kind", one_of(kSensors, "kind of sensor", sensor.kind)},
         {"at", pose("a mount such as [100, 0, 0]: mm forward, mm to the right, degrees clockwise",
                     sensor.mount)},
         {"height", real<Range{0, 1e5}>(height)},
         {"tilt", tilt},
         {"axis", [&](const Node& n) { axis(n, sensor.axis); }},
         {"range", size(sensor.max_range)},
         {"noise", [&](const Node& n) { noise(n, sensor.noise); }},
         {"lag", duration(sensor.lag)},
         {"outages", [&](const Node& n) { outages(n, sensor.outages); }},
         {"period", duration(sensor.period)},
         {"size", of_camera(camera, [&](const Node& n) { picture_size(n, sensor.camera); })},
         {"fov", of_camera(camera, real<Range{10, 140}>(camera.fov))},
         {"focal", of_camera(camera, real<Range{10, 1e5}>(camera.focal))},
         {"lens", of_camera(camera, [&](const Node& n) { lens(n, sensor.camera); })},
         {"rate", of_camera(camera, real<Range{0.1, 60}>(camera.rate))},
         {"quality", of_camera(camera, [&](const Node& n) { quality(n, sensor.camera); })},
         {"device", text(sensor.device)},
         {"line", text(sensor.line)}});
    sensor.mount.z = -height;
    require(node, "name");
    require(node, "kind");
    if (sensor.period.count() != 0) fix_period(node, sensor);
    finish_camera(node, camera, sensor);
    if (sensor.axis.about != TurnedAbout::kNothing && sensor.kind != SensorKind::kScanner &&
        sensor.kind != SensorKind::kScanner3d)
      reader_.add({node.at_key, sensor.name + ": only scanners have an axis"});
    if (std::ranges::find(sensors, sensor.name, &SensorDescription::name) != sensors.end())
      reader_.add({node.at_key, fmt::format("there is another sensor {}", sensor.name)});
    if (has_room(node, sensors, kSensorsMax, "sensors at one robot"))
      sensors.push_back(std::move(sensor));
  }

  // Keys of cameras, in their own units.
  struct CameraKeys {
    double fov = 0;  // degrees; 0: not given
    double focal = 0;
    double rate = 15;             // 1/s
    const Node* first = nullptr;  // of these keys
  };
  static Read of_camera(CameraKeys& keys, Read read) {
    return [&keys, read = std::move(read)](const Node& node) {
      if (keys.first == nullptr) keys.first = &node;
      read(node);
    };
  }

  void picture_size(const Node& node, CameraDescription& camera) {
    std::array<double, 2> value{};
    numbers(node, "a size such as [640, 480]: pixels of width and height", value);
    const auto is_side = [](double pixels) {
      return pixels >= kPictureMin && pixels <= kPictureMax && pixels == std::floor(pixels);
    };
    if (!is_side(value[0]) || !is_side(value[1]))
      return reader_.refuse(node, fmt::format("size must be two whole numbers from {} to {}",
                                              kPictureMin, kPictureMax));
    camera.width = static_cast<int>(value[0]);
    camera.height = static_cast<int>(value[1]);
  }
  void lens(const Node& node, CameraDescription& camera) {
    std::array<double, 2> value{};
    numbers(node, "two coefficients such as [-0.1, 0.01]: k1, k2 of OpenCV", value);
    camera.k1 = value[0];
    camera.k2 = value[1];
  }
  void quality(const Node& node, CameraDescription& camera) {
    std::int64_t value = camera.quality;
    reader_.number(node, 1, 100, value);
    camera.quality = static_cast<int>(value);
  }

  void finish_camera(const Node& node, const CameraKeys& keys, SensorDescription& sensor) {
    if (sensor.kind != SensorKind::kCamera) {
      if (keys.first != nullptr)
        reader_.add({keys.first->at_key, fmt::format("only cameras have {}", keys.first->key)});
      return;
    }
    CameraDescription& camera = sensor.camera;
    if (keys.fov > 0 && keys.focal > 0)
      reader_.add({node.at_key, "a camera has fov, in degrees, or focal, in pixels"});
    constexpr double kUsualFov = 60;
    const double fov = radians(keys.fov > 0 ? keys.fov : kUsualFov);
    camera.focal = keys.focal > 0 ? keys.focal : camera.width / 2.0 / std::tan(fov / 2);
    sensor.period =
        std::chrono::duration_cast<tims::Duration>(std::chrono::duration<double>(1 / keys.rate));
    if (!is_possible(camera))
      reader_.add({node.at_key,
                   fmt::format("{}: no lens is like this: with these k1 and k2, or this fov, the "
                               "corners of the picture see nothing within 72 degrees of the axis",
                               sensor.name)});
  }

  void axis(const Node& node, AxisDescription& axis) {
    reader_.table(node, "axis",
                  {{"about", one_of(kAxes, "axis", axis.about)},
                   {"gear_ratio", real<Range{1e-3, 1e4}>(axis.gear_ratio)},
                   {"device", text(axis.device)},
                   {"line", text(axis.line)}});
    require(node, "about");
  }

  void fix_period(const Node& node, const SensorDescription& sensor) {
    constexpr tims::Duration kShortest = std::chrono::milliseconds(50);
    constexpr tims::Duration kLongest = std::chrono::minutes(1);
    if (sensor.kind != SensorKind::kSatellite)
      reader_.add({node.at_key, sensor.name + ": only satellite receivers have a period"});
    else if (sensor.period < kShortest || sensor.period > kLongest)
      reader_.add({node.at_key, sensor.name + ": period is from 50ms to 1min"});
  }

  // ["60s to 90s"]
  void outages(const Node& node, std::vector<Outage>& out) {
    reader_.texts(node, [&](const Node& item, const std::string& value) {
      constexpr std::string_view kTo = " to ";
      const auto middle = value.find(kTo);
      const std::string_view text = value;
      const auto from = tims::base::parse_duration(text.substr(0, middle));
      const auto to = middle == std::string::npos
                          ? std::nullopt
                          : tims::base::parse_duration(text.substr(middle + kTo.size()));
      if (!from || !to || *to <= *from)
        return reader_.refuse(item, fmt::format("outages must be times after the begin such as "
                                                "\"60s to 90s\", not \"{}\"",
                                                value));
      out.push_back({*from, *to});
    });
  }

  // Makes the ground as large as its objects, and some metres around the robots.
  void fit_ground() {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    constexpr double kRound = 5000;
    constexpr double kThick = 1000;
    MapPoint low{kInfinite, kInfinite};
    MapPoint high{-kInfinite, -kInfinite};
    const auto add = [&](const MapPoint& p, double around) {
      low = {std::min(low.x, p.x - around), std::min(low.y, p.y - around)};
      high = {std::max(high.x, p.x + around), std::max(high.y, p.y + around)};
    };
    WorldDescription& world = file_.description;
    for (const WallDescription& wall : world.walls) {
      add(wall.from, kThick);
      add(wall.to, kThick);
    }
    for (const ObstacleDescription& obstacle : world.obstacles)
      add(obstacle.at, world.walls.empty() ? kRound : kThick);
    for (const RobotDescription& robot : world.robots)
      add({robot.start.x, robot.start.y}, world.walls.empty() ? 10 * kRound : 0);
    if (low.x < high.x) world.ground = {low, high};
  }

  const ReadPlan& read_plan_;
  const DecodePicture& decode_;
  Reader reader_;
  WorldFile file_;
  bool value_full_ = false;
};

}  // namespace

WorldFile read_world(const tims::base::TextFile& file, const ReadPlan& read_plan,
                     const DecodePicture& decode) {
  return WorldReader(read_plan, decode).read(file);
}

}  // namespace rack::world
