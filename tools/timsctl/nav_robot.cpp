#include "tools/timsctl/nav_robot.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.h"
#include "components/geometry/pose.h"
#include "os/clock.h"

namespace timsctl {

namespace {

constexpr tims::Duration kNavRobotOnPatience = std::chrono::seconds(10);
constexpr std::uint32_t kAnswerMax = 1U << 20;  // a path of 6000 splines
constexpr std::uint32_t kSlots = 16;

const rack::Parameter* find(const rack::ParameterList& list, std::string_view name) {
  const auto found = std::ranges::find_if(
      list.parameters, [&](const rack::Parameter& p) { return p.name.view() == name; });
  return found == list.parameters.end() ? nullptr : &*found;
}

bool drives(std::uint32_t class_id) {
  namespace id = tims::class_id;
  for (const std::uint32_t known : {id::kPosition, id::kMcl, id::kPath, id::kPilot, id::kFeatureMap,
                                    id::kGridMap, id::kChassis, id::kGps})
    if (known == class_id) return true;
  return false;
}

}  // namespace

double metres(rack::Millimetres<rack::i32> length) { return length.si(); }

json::object pose_json(const rack::Position3d& pos) {
  return {{"x_m", metres(pos.x)},
          {"y_m", metres(pos.y)},
          {"heading_deg", rack::degrees(rack::heading(static_cast<double>(pos.rho)))}};
}

std::string place_text(double x_m, double y_m) {
  return fmt::format("x {:.2f} m, y {:.2f} m", x_m, y_m);
}

double age_s(rack::TimeStamp recorded) {
  const auto now = std::chrono::duration_cast<std::chrono::milliseconds>(
      tims::os::wall_now().time_since_epoch());
  return std::chrono::duration<double>(rack::TimeStamp::of(now) - recorded).count();
}

NavRobot::NavRobot(Context& context, std::string wanted)
    : client_(context, {.address = {}, .slots = kSlots, .body_max = kAnswerMax}),
      is_here_(std::holds_alternative<UnixHost>(context.host) && context.options.router.empty()) {
  if (wanted.empty()) wanted = context.options.robot;
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const auto add_all = [&](const json::object& answer) {
    for (const json::object& item : objects(items_of(answer))) {
      const auto address = parse_address(text_at(item, "address.raw"), client_.widths());
      if (!address) continue;
      const auto fields = address->fields(client_.widths());
      if (fields.local != 0 || !drives(fields.class_id)) continue;
      // The first router to name a process is the one of this host.
      if (const double process = number_or_zero(item, "owner.pid"); process > 0)
        processes_.try_emplace(*address, static_cast<std::int64_t>(process));
      const double age = number_or_zero(item, "age_s");
      const auto [youngest, is_first] = settled_s_.try_emplace(fields.system, age);
      if (!is_first) youngest->second = std::min(youngest->second, age);
      auto& list = found_[fields.system][fields.class_id];
      if (std::ranges::find(list, *address) == list.end()) list.push_back(*address);
    }
  };
  add_all(admin.ask({{"ask", "mailboxes"}}));
  // A named robot may be a neighbour.
  if (found_.empty() || !wanted.empty()) add_all(ask_everywhere(admin, {{"ask", "mailboxes"}}));
  choose(wanted, admin);
  for (auto& [class_id, list] : found_[system_]) std::ranges::sort(list);
}

void NavRobot::choose(const std::string& wanted, AdminClient& admin) {
  std::string known;
  for (const auto& [system, components] : found_)
    known += (known.empty() ? "" : ", ") + std::to_string(system);
  if (wanted.empty() && found_.size() == 1) {
    system_ = found_.begin()->first;
    return;
  }
  if (found_.empty())
    throw Failure(Exit::kNoSuch, "no_robot", "no component of a robot is registered",
                  "`timsctl up FILE` starts the components of a robot");
  if (wanted.empty())
    throw usage_error("the robot is ambiguous; known systems: " + known,
                      "use --robot with the system number or the name of the router");
  const auto number = base::parse_number<std::uint32_t>(wanted);
  system_ = number ? *number : find_router(admin, wanted).fields(client_.widths()).system;
  if (!found_.contains(system_))
    throw Failure(Exit::kNoSuch, "no_such_robot",
                  fmt::format("{} has no components for driving", title()),
                  "known systems: " + known);
}

const std::vector<tims::Address>& NavRobot::all(std::uint32_t class_id) const {
  static const std::vector<tims::Address> kNone;
  const auto& mine = found_.at(system_);
  const auto found = mine.find(class_id);
  return found == mine.end() ? kNone : found->second;
}

std::optional<tims::Address> NavRobot::first(std::uint32_t class_id) const {
  const auto& list = all(class_id);
  return list.empty() ? std::nullopt : std::optional(list.front());
}

tims::Address NavRobot::need(std::uint32_t class_id, const std::string& program) const {
  if (const auto found = first(class_id)) return *found;
  throw Failure(Exit::kNoSuch, "no_component", fmt::format("{} has no {}", title(), program),
                fmt::format("start {}, preferably with the robot file (`timsctl up`)", program));
}

tims::Result<std::filesystem::path> NavRobot::path_of(tims::Address component,
                                                      const std::string& file) const {
  if (std::filesystem::path(file).is_absolute()) return std::filesystem::path(file);
  const auto process = processes_.find(component);
  if (!is_here_ || process == processes_.end())
    return tims::Error(tims::Errc::kSystem,
                       fmt::format("{} of {} is on another host", file, name(component)));
  std::error_code error;
  const auto folder =
      std::filesystem::read_symlink(fmt::format("/proc/{}/cwd", process->second), error);
  if (error)
    return tims::Error(tims::Errc::kSystem,
                       fmt::format("{} is relative to the working directory of {} (process {}), "
                                   "which cannot be read: {}",
                                   file, name(component), process->second, error.message()));
  return folder / file;
}

std::string NavRobot::state(tims::Address component) {
  const auto states = client_.states({&component, 1});
  return states.front() ? state_text(*states.front()) : "silent";
}

std::optional<std::string> NavRobot::turn_on(tims::Address component) {
  const Message answer =
      client_.ask(component, tims::type::kOn, rack::OnRequest{}, kNavRobotOnPatience);
  if (answer.header.type == tims::type::kOk) return std::nullopt;
  return std::string(rack::reason_of(answer.body));
}

void NavRobot::need_on(tims::Address component) {
  const auto why = turn_on(component);
  if (!why) return;
  throw Failure(
      Exit::kNo, "refused",
      name(component) + " cannot be turned on" + (why->empty() ? "" : ": " + *why),
      fmt::format("`timsctl component show {}`, `timsctl log follow`", plain_name(component)));
}

std::optional<tims::Address> NavRobot::linked(const rack::ParameterList& parameters,
                                              std::string_view name, std::uint32_t class_id) const {
  const auto system = integer_of(parameters, std::string(name) + "Sys");
  const auto instance = integer_of(parameters, std::string(name) + "Inst");
  if (!system || !instance || *system < 0 || *instance < 0) return std::nullopt;
  return tims::Address::of({.system = static_cast<std::uint32_t>(*system),
                            .class_id = class_id,
                            .instance = static_cast<std::uint32_t>(*instance)},
                           client_.widths());
}

std::optional<std::int32_t> integer_of(const rack::ParameterList& list, std::string_view name) {
  const rack::Parameter* found = find(list, name);
  if (found == nullptr || found->type != rack::Parameter::kInt) return std::nullopt;
  return found->valueInt;
}

std::optional<std::string> text_of(const rack::ParameterList& list, std::string_view name) {
  const rack::Parameter* found = find(list, name);
  if (found == nullptr || found->type != rack::Parameter::kString) return std::nullopt;
  return std::string(found->valueString.view());
}

bool knows_earth(const rack::ParameterList& of_position) {
  const auto is_set = [&](std::string_view name) { return number_of(of_position, name, 0) != 0; };
  if (!is_set("positionReference")) return is_set("scaleLatitude") && is_set("scaleLongitude");
  return is_set("offsetNorthing") || is_set("offsetEasting");
}

double number_of(const rack::ParameterList& list, std::string_view name, double otherwise) {
  const rack::Parameter* found = find(list, name);
  if (found == nullptr || found->type == rack::Parameter::kString) return otherwise;
  return found->type == rack::Parameter::kInt ? found->valueInt
                                              : static_cast<double>(found->valueFloat);
}

}  // namespace timsctl
