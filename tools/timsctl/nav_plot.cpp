#include "tools/timsctl/nav_plot.h"

#include <filesystem>

#include <fmt/format.h>

#include "base/text.h"
#include "components/files/loaded_library.h"
#include "components/files/whole_file.h"
#include "components/position/map_file.h"
#include "os/file.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/grid_map.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/position.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/plot/trajectory_files.h"
#include "tools/timsctl/command_line.h"

namespace timsctl {

namespace {

namespace id = tims::class_id;

using rack::localisation::GridMap;
using rack::plot::Picture;

constexpr double kDrawnCell = 50;  // mm

bool is_map(const std::string& file) {
  return rack::localisation::is_ros_map(file) || tims::base::lower(file).ends_with(".dxf");
}

// Checks the form before any request or file access.
void check_form(const std::string& file) {
  if (!file.ends_with(".svg") && !file.ends_with(".png"))
    throw usage_error(fmt::format("{}: a picture must be .svg or .png", file));
}

template <typename T>
T well(tims::Result<T> result) {
  if (result) return std::move(result).value();
  const bool broken = result.error() == tims::Errc::kMalformed;
  throw Failure(broken ? Exit::kNo : Exit::kNoSuch, broken ? "bad_file" : "no_such_file",
                result.error().detail());
}

void write_text(const std::string& file, const std::string& text) {
  if (auto written = rack::write_file(file, text); !written)
    throw Failure(Exit::kDenied, "not_written", written.error().detail());
}

std::string png_of(const std::string& file, const Picture& picture) {
  const auto draw_png = rack::load_function<rack::pictures::DrawPng>(
      rack::kPicturesLibrary, rack::pictures::kDrawPngSymbol);
  if (!draw_png)
    throw Failure(Exit::kNo, "no_opencv",
                  fmt::format("{}: PNG needs {}", file, draw_png.error().detail()),
                  "or name it .svg, which does not need OpenCV");
  auto png = rack::plot::to_png(picture, *draw_png);
  if (!png)
    throw Failure(Exit::kDenied, "not_written", fmt::format("{}: {}", file, png.error().detail()),
                  ".svg has no such limit");
  return std::move(png).value();
}

// What of a file is not in the map.
void print_remarks(const std::vector<std::string>& remarks) {
  for (const std::string& remark : remarks) fmt::print(stderr, "{}\n", remark);
}

// Reads the file like the component does.
std::optional<GridMap> map_from_file(NavRobot& robot, tims::Address component,
                                     std::vector<std::string>& missing) {
  const rack::ParameterList parameters = robot.client().parameters(component);
  const auto file = text_of(parameters, "mapFile");
  if (!file || file->empty()) return std::nullopt;
  const auto path = robot.path_of(component, *file);
  if (!path) {
    missing.push_back(path.error().detail());
    return std::nullopt;
  }
  auto map = rack::navigation::load_map(path->string(),
                                        {.scale = number_of(parameters, "mapScaleFactor", 1000),
                                         .offset_x = number_of(parameters, "mapOffsetX", 0),
                                         .offset_y = number_of(parameters, "mapOffsetY", 0),
                                         .layers = text_of(parameters, "mapLayers").value_or("")},
                                        number_of(parameters, "mapResolution", kDrawnCell));
  if (!map) {
    missing.push_back(map.error().detail());
    return std::nullopt;
  }
  print_remarks(map->remarks);
  return std::move(map->map);
}

std::optional<GridMap> map_of(NavRobot& robot, std::vector<std::string>& missing) {
  for (const std::uint32_t class_id : {id::kMcl, id::kGridMap, id::kPath})
    for (const tims::Address component : robot.all(class_id))
      if (auto map = map_from_file(robot, component, missing)) return map;
  for (const tims::Address component : robot.all(id::kGridMap))
    if (const auto data = robot.data<rack::GridMapData>(component))
      if (auto map = rack::localisation::read_map(*data)) return std::move(*map);
  for (const tims::Address component : robot.all(id::kFeatureMap))
    if (const auto data = robot.data<rack::FeatureMapData>(component))
      if (auto map = rack::localisation::read_map(*data, kDrawnCell)) return std::move(*map);
  return std::nullopt;
}

// In the unit of the plan, or else in metres.
GridMap map_from_argument(const std::string& file) {
  auto loaded = well(rack::navigation::load_map(file, {.scale = 0, .scale_otherwise = 1000}));
  print_remarks(loaded.remarks);
  return std::move(loaded.map);
}

}  // namespace

void write_picture(const std::string& file, const Picture& picture) {
  check_form(file);
  if (picture.empty())
    throw Failure(Exit::kNo, "nothing_to_draw", file + ": there is nothing to draw",
                  "are the components on? `timsctl nav where`");
  write_text(file, file.ends_with(".svg") ? rack::plot::to_svg(picture) : png_of(file, picture));
}

RobotPicture picture_of(NavRobot& robot) {
  RobotPicture made;
  Picture& picture = made.picture;
  picture.map = map_of(robot, made.missing_maps);
  if (picture.map) made.missing_maps.clear();
  if (const auto mcl = robot.first(id::kMcl))
    if (const auto data = robot.data<rack::MclData>(*mcl))
      for (const rack::MclDataPoint& point : data->points)
        if (point.type == rack::mcl_point::kSample)
          picture.dots.push_back({static_cast<double>(point.x), static_cast<double>(point.y)});
  if (const auto position = robot.first(id::kPosition))
    if (const auto data = robot.data<rack::PositionData>(*position))
      picture.marks.push_back({robot.title(), rack::Pose::of(data->pos)});
  return made;
}

Exit nav_plot(Context& context) {
  const auto& arguments = context.options.arguments;
  check_form(arguments[0]);
  Picture picture;
  for (const std::string& argument : std::span(arguments).subspan(1)) {
    const std::size_t equals = argument.find('=');
    const bool named = equals != std::string::npos && equals < argument.find('/');
    const std::string name = named ? argument.substr(0, equals) : "";
    const std::string file = named ? argument.substr(equals + 1) : argument;
    if (is_map(file)) {
      picture.map = map_from_argument(file);
      continue;
    }
    const std::string text = well(tims::os::read_file(file));
    if (auto added = rack::plot::add_file(text, name, picture); !added)
      throw Failure(Exit::kNo, "bad_file", file + ": " + added.error().detail());
  }
  if (picture.series.empty()) picture.series = rack::plot::errors_of(picture.trajectories);
  write_picture(arguments[0], picture);
  json::array trajectories;
  for (const auto& trajectory : picture.trajectories)
    trajectories.push_back(
        json::object{{"name", trajectory.name}, {"points", trajectory.points.size()}});
  const json::object answer{{"schema", "tims/nav_plot/1"},
                            {"picture", arguments[0]},
                            {"tracks", trajectories},
                            {"diagrams", picture.series.size()}};
  if (context.out.json()) context.out.write(answer);
  context.out.note(fmt::format("{}: {} trajectories, {} curves over time", arguments[0],
                               picture.trajectories.size(), picture.series.size()));
  return Exit::kDone;
}

}  // namespace timsctl
