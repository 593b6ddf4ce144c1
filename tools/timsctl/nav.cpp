// timsctl nav where, path, map: the pose of a robot, its path, its maps.
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "components/geometry/pose.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/path.h"
#include "rack/proxies/position.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/plot/trajectory_files.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/nav_plot.h"
#include "tools/timsctl/nav_report.h"
#include "tools/timsctl/nav_robot.h"

namespace timsctl {

namespace {

namespace id = tims::class_id;

std::string robot_argument(const Context& context) {
  return context.options.arguments.empty() ? "" : context.options.arguments.front();
}

// --- where

class Where {
 public:
  explicit Where(NavRobot& robot)
      : robot_(robot), position_(robot.need(id::kPosition, "Position")) {}

  [[nodiscard]] bool known() const { return known_; }

  json::object look() {
    json::object answer{{"schema", "tims/nav_where/1"},
                        {"system", robot_.number()},
                        {"position", address_json(position_, robot_.client().widths())}};
    WhereFacts facts;
    facts.position = robot_.plain_name(position_);
    facts.position_state = robot_.state(position_);
    facts.has_gps = robot_.first(id::kGps).has_value();
    answer["state"] = facts.position_state;
    const auto data = robot_.data<rack::PositionData>(position_);
    known_ = data.has_value();
    if (data) {
      answer["pose"] = pose_json(data->pos);
      answer["deviation"] =
          json::object{{"x_m", metres(data->var.x)},
                       {"y_m", metres(data->var.y)},
                       {"heading_deg", rack::degrees(static_cast<double>(data->var.rho))}};
      facts.age_s = age_s(data->recordingTime);
      answer["age_s"] = *facts.age_s;
      add_earth(answer, *data);
    }
    add_localiser(answer, facts);
    json::array findings;
    for (const MissingPart& finding : missing(facts))
      findings.push_back(json::object{{"what", finding.what}, {"next", finding.next}});
    answer["missing"] = std::move(findings);
    return answer;
  }

 private:
  // Known only if the geographic position of the origin was configured.
  void add_earth(json::object& answer, const rack::PositionData& data) {
    if (!knows_earth(robot_.client().parameters(position_))) return;
    const Message reply = robot_.client().ask(position_, rack::PositionType::kPosToWgs84, data);
    if (reply.header.type != rack::PositionType::kWgs84) return;
    const auto earth =
        value_or_fail(rack::decode<rack::PositionWgs84Data>(reply.view()), robot_.name(position_));
    answer["latitude_deg"] = rack::degrees(earth.latitude);
    answer["longitude_deg"] = rack::degrees(earth.longitude);
  }

  void add_localiser(json::object& answer, WhereFacts& facts) {
    const auto mcl = robot_.first(id::kMcl);
    if (!mcl) return;
    const auto parameters = robot_.client().parameters(*mcl);
    const std::string map = text_of(parameters, "mapFile").value_or("");
    facts.mcl = robot_.plain_name(*mcl);
    facts.mcl_state = robot_.state(*mcl);
    facts.mcl_has_map = !map.empty();
    facts.mcl_sends_pose = robot_.linked(parameters, "position", id::kPosition) == position_;
    json::object part{{"address", address_json(*mcl, robot_.client().widths())},
                      {"state", facts.mcl_state},
                      {"map", map.empty() ? json::value() : json::value(map)}};
    if (const auto data = robot_.data<rack::MclData>(*mcl)) {
      facts.samples = samples_of(*data);
      part["samples"] = facts.samples->count;
      part["spread_m"] = facts.samples->spread_m;
      part["pose"] = pose_json(data->pos);
      if (const auto then = robot_.data<rack::PositionData>(position_, data->recordingTime)) {
        facts.apart_m = std::hypot(metres(then->pos.x) - metres(data->pos.x),
                                   metres(then->pos.y) - metres(data->pos.y));
        part["apart_m"] = *facts.apart_m;
      }
    }
    answer["localisation"] = std::move(part);
  }

  NavRobot& robot_;
  tims::Address position_;
  bool known_ = false;
};

std::string where_text(const json::object& answer, const Look& look) {
  const auto number = [&](std::string_view path) { return number_or_zero(answer, path); };
  std::string text;
  const auto line = [&](const std::string& title, const std::string& value) {
    text += fmt::format("{:<14}  {}\n", title + ":", value);
  };
  if (at_path(answer, "pose") != nullptr) {
    line("Place",
         fmt::format("{}, heading {:.1f} deg", place_text(number("pose.x_m"), number("pose.y_m")),
                     number("pose.heading_deg")));
    if (at_path(answer, "latitude_deg") != nullptr)
      line("On Earth", fmt::format("{:.7f} north, {:.7f} east", number("latitude_deg"),
                                   number("longitude_deg")));
    line("Deviation", fmt::format("{:.2f} m, {:.2f} m, {:.1f} deg", number("deviation.x_m"),
                                  number("deviation.y_m"), number("deviation.heading_deg")));
    line("Source", fmt::format("{}, {} ago", text_at(answer, "position.name"),
                               base::human_duration(std::max(0.0, number("age_s")))));
  } else {
    line("Place", fmt::format("unknown: {} is {}", text_at(answer, "position.name"),
                              text_at(answer, "state")));
  }
  if (at_path(answer, "localisation") != nullptr) {
    std::string localisation = fmt::format("{} {}", text_at(answer, "localisation.address.name"),
                                           text_at(answer, "localisation.state"));
    if (const std::string map = text_at(answer, "localisation.map"); !map.empty())
      localisation += ", map " + map;
    if (at_path(answer, "localisation.samples") != nullptr)
      localisation += fmt::format(", {:.0f} samples within {:.2f} m",
                                  number("localisation.samples"), number("localisation.spread_m"));
    line("Localisation", localisation);
  }
  for (const json::object& finding : objects(items_of(answer, "missing"))) {
    text += paint("Missing:        " + text_at(finding, "what"), Tone::kWarning, look.colour);
    text += "\n  -> " + text_at(finding, "next") + "\n";
  }
  return text;
}

}  // namespace

Exit nav_where(Context& context) {
  NavRobot robot(context, robot_argument(context));
  Where where(robot);
  const Exit shown = show(
      context, [&](AdminClient&) { return where.look(); }, where_text);
  return shown == Exit::kDone && !where.known() ? Exit::kNo : shown;
}

// --- path

namespace {

constexpr Column kSplines[] = {
    {"NR", "nr"},           {"KIND", "kind"},
    {"LENGTH", "length"},   {"RADIUS", "radius"},
    {"SPEED", "speed"},     {"END", "end"},
    {"HEADING", "heading"}, {"CORRIDOR", "corridor", Cell::kText, true},
};

// Numbers for programs, and texts for the table.
json::object spline_json(const rack::PolarSpline& spline, std::size_t number) {
  const bool line = spline.radius == 0;
  const bool back = spline.length < 0;
  const char* kind = line ? "line" : spline.radius > 0 ? "arc to the right" : "arc to the left";
  const double heading = rack::degrees(static_cast<double>(spline.endPos.rho));
  return {
      {"nr", std::to_string(number)},
      {"kind", std::string(kind) + (back ? ", backward" : "")},
      {"length_m", metres(spline.length)},
      {"radius_m", metres(spline.radius)},
      {"start_mps", spline.vStart.si()},
      {"end_mps", spline.vEnd.si()},
      {"max_mps", spline.vMax.si()},
      {"corridor_m", metres(spline.lbo)},
      {"end_x_m", metres(spline.endPos.x)},
      {"end_y_m", metres(spline.endPos.y)},
      {"end_heading_deg", heading},
      {"length", fmt::format("{:.2f} m", std::abs(metres(spline.length)))},
      {"radius", line ? "-" : fmt::format("{:.2f} m", std::abs(metres(spline.radius)))},
      {"speed", fmt::format("{:.2f} .. {:.2f} m/s", spline.vStart.si(), spline.vEnd.si())},
      {"end", fmt::format("{:.2f}, {:.2f} m", metres(spline.endPos.x), metres(spline.endPos.y))},
      {"heading", fmt::format("{:.1f} deg", heading)},
      {"corridor", fmt::format("{:.2f} m", metres(spline.lbo))}};
}

std::vector<rack::PolarSpline> splines_of(const rack::PathData& data) {
  return {data.splines.begin(), data.splines.end()};
}

json::object path_json(NavRobot& robot, tims::Address path, const rack::PathData& data) {
  json::array items;
  for (const rack::PolarSpline& spline : data.splines)
    items.push_back(spline_json(spline, items.size()));
  const PathSummary sum = summary_of(splines_of(data));
  return {{"schema", "tims/nav_path/1"},
          {"path", address_json(path, robot.client().widths())},
          {"age_s", age_s(data.recordingTime)},
          {"length_m", sum.length_m},
          {"seconds", sum.seconds},
          {"items", std::move(items)}};
}

}  // namespace

Exit nav_path(Context& context) {
  NavRobot robot(context, robot_argument(context));
  const tims::Address path = robot.need(id::kPath, "PathRDDF");
  rack::PathData data;
  const auto ask = [&](AdminClient&) {
    auto newest = robot.data<rack::PathData>(path);
    if (!newest)
      throw Failure(Exit::kNo, "no_data", robot.name(path) + " is " + robot.state(path),
                    fmt::format("`timsctl component on {}`", robot.plain_name(path)));
    data = std::move(*newest);
    json::object answer = path_json(robot, path, data);
    if (const std::string& by = context.options.sort; !by.empty())
      sort_items(item_array(answer), kSplines, by);
    return answer;
  };
  const auto draw = [](const json::object& answer, const Look& look) {
    const auto items = items_of(answer);
    std::string text = items.empty() ? "" : render_items(items, kSplines, look);
    if (!look.for_people()) return text;
    if (items.empty()) return std::string("no path\n");
    return text + fmt::format("{:.2f} m in {:.0f} s\n", number_or_zero(answer, "length_m"),
                              number_or_zero(answer, "seconds"));
  };
  const Exit shown = show(context, ask, draw);
  if (context.options.plot.empty()) return shown;
  RobotPicture made = picture_of(robot);
  if (!data.splines.empty())
    made.picture.trajectories.push_back(rack::plot::trajectory_of(splines_of(data), "path"));
  write_picture(context.options.plot, made.picture);
  for (const std::string& why : made.missing_maps)
    context.out.note(context.options.plot + " has no map: " + why);
  return made.missing_maps.empty() ? shown : Exit::kNo;
}

// --- map

namespace {

constexpr Column kMaps[] = {
    {"ADDRESS", "address.name"},
    {"STATE", "state"},
    {"MAP", "map"},
    {"CHANGE", "change", Cell::kText, true},
};

// A component that uses a map, and how it loads one.
struct MapUser {
  tims::Address component;
  bool loads = false;  // LOAD_MAP, at once; else its parameter, at the next ON
  rack::ParameterList parameters{};
};

std::vector<MapUser> map_users(NavRobot& robot) {
  std::vector<MapUser> users;
  for (const std::uint32_t class_id : {id::kMcl, id::kFeatureMap, id::kGridMap, id::kPath})
    for (const tims::Address component : robot.all(class_id)) {
      MapUser user{.component = component,
                   .loads = class_id == id::kMcl || class_id == id::kFeatureMap,
                   .parameters = robot.client().parameters(component)};
      if (text_of(user.parameters, "mapFile")) users.push_back(std::move(user));
    }
  return users;
}

std::string map_name(NavRobot& robot, const MapUser& user) {
  if (const auto file = text_of(user.parameters, "mapFile"); file && !file->empty()) return *file;
  if (const auto grid = robot.linked(user.parameters, "gridMap", id::kGridMap))
    return "that of " + robot.name(*grid);
  return {};
}

json::object user_json(NavRobot& robot, const MapUser& user) {
  const std::string map = map_name(robot, user);
  return {{"address", address_json(user.component, robot.client().widths())},
          {"state", robot.state(user.component)},
          {"map", map.empty() ? json::value() : json::value(map)},
          {"change", user.loads ? "at once" : "at the next ON"}};
}

void need_users(const NavRobot& robot, const std::vector<MapUser>& users) {
  if (users.empty())
    throw Failure(Exit::kNoSuch, "no_component",
                  robot.title() + " has no component that uses a map",
                  "start MonteCarloLocalisation, GridMap or PathRDDF");
}

Exit map_show(Context& context, NavRobot& robot) {
  const auto users = map_users(robot);
  need_users(robot, users);
  json::array items;
  for (const MapUser& user : users) items.push_back(user_json(robot, user));
  const Exit shown = show_list(context, "tims/nav_map/1", std::move(items), kMaps);
  if (context.options.plot.empty()) return shown;
  const RobotPicture made = picture_of(robot);
  if (!made.picture.map) {
    std::string why;
    for (const std::string& missing : made.missing_maps) why += "; " + missing;
    throw Failure(Exit::kNo, "no_map",
                  context.options.plot + " was not written: no map of " + robot.title() +
                      " is available here" + why,
                  "turn a GridMap or FeatureMap on, or give components the absolute path of a "
                  "map on this host");
  }
  write_picture(context.options.plot, made.picture);
  return shown;
}

// A local file is passed as an absolute path, so that programs in other folders find it. From
// another host only names in the robot's own folder are accepted.
std::string whole_path(const Host& host, const std::string& file) {
  std::error_code error;
  const bool is_here = std::holds_alternative<UnixHost>(host);
  return is_here && std::filesystem::exists(file, error) ? std::filesystem::absolute(file).string()
                                                         : file;
}

// Empty on success, else the reason.
std::optional<std::string> give_map(NavRobot& robot, const MapUser& user, const std::string& file) {
  if (user.loads) {
    // FeatureMap's has the same number.
    const Message answer = robot.client().ask(user.component, rack::MclType::kLoadMap,
                                              rack::FileName::of(file), std::chrono::seconds(30));
    if (answer.header.type == tims::type::kOk) return std::nullopt;
    return std::string(rack::reason_of(answer.body));
  }
  rack::ParameterList request;
  rack::Parameter& parameter = request.parameters.emplace_back();
  (void)parameter.name.assign("mapFile");
  parameter.type = rack::Parameter::kString;
  if (!parameter.valueString.assign(file)) return "the path exceeds the 79 bytes of its parameter";
  const Message answer = robot.client().ask(user.component, tims::type::kSetParam, request);
  if (answer.header.type == tims::type::kOk) return std::nullopt;
  return std::string(rack::reason_of(answer.body));
}

Exit map_load(Context& context, NavRobot& robot, const std::string& given) {
  const auto users = map_users(robot);
  need_users(robot, users);
  const std::string file = whole_path(context.host, given);
  if (file.size() >= decltype(rack::FileName::name)::kMax)
    throw usage_error(file + ": exceeds the 126 bytes of LOAD_MAP");
  Exit exit = Exit::kDone;
  json::array items;
  for (const MapUser& user : users) {
    const std::string component = robot.name(user.component);
    json::object item = user_json(robot, user);
    if (text_of(user.parameters, "mapFile")->empty() &&
        robot.linked(user.parameters, "gridMap", id::kGridMap)) {
      item["result"] = "skipped: it uses the map of another component";
    } else if (const auto why = give_map(robot, user, file)) {
      exit = Exit::kNo;
      item["result"] = "refused";
      item["why"] = *why;
      context.out.note(component + " refuses the map" + (why->empty() ? "" : ": " + *why));
    } else {
      const bool later = !user.loads && text_at(item, "state") == "on";
      item["result"] = later ? "at the next ON" : "loaded";
      item["map"] = file;
      if (later)
        context.out.note(fmt::format("{0}: `timsctl component off {0}`, then on",
                                     robot.plain_name(user.component)));
    }
    items.push_back(std::move(item));
  }
  constexpr Column kLoaded[] = {{"ADDRESS", "address.name"}, {"RESULT", "result"}, {"MAP", "map"}};
  (void)show_list(context, "tims/nav_map_load/1", std::move(items), kLoaded);
  return exit;
}

}  // namespace

Exit nav_map(Context& context) {
  const auto& arguments = context.options.arguments;
  const std::string what = arguments.empty() ? "show" : arguments.front();
  const bool loads = what == "load" && arguments.size() == 2;
  if (!loads && (what != "show" || arguments.size() > 1))
    throw usage_error("nav map: expected show or load FILE");
  NavRobot robot(context);
  return loads ? map_load(context, robot, arguments[1]) : map_show(context, robot);
}

}  // namespace timsctl
