// The components of a robot that localise, plan and drive, for `timsctl nav`. They are found by
// their classes; their parameters (pathSys, pathInst) define how they are connected.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rack/proxies/generic.h"
#include "rack/proxies/geometry.h"
#include "tims/result.h"
#include "tools/timsctl/component_client.h"

namespace timsctl {

// Values for the user: m, and degrees clockwise from x (north), 0 to 360.
json::object pose_json(const rack::Position3d& pos);
std::string place_text(double x_m, double y_m);
double metres(rack::Millimetres<rack::i32> length);
// The age of data of this time, such as "0.03 s"; the clocks of two hosts may differ.
double age_s(rack::TimeStamp recorded);

class NavRobot {
 public:
  // `wanted`: a system number or the name of a router; empty: --robot, or the only robot. Throws
  // Failure.
  explicit NavRobot(Context& context, std::string wanted = {});

  [[nodiscard]] ComponentClient& client() { return client_; }
  [[nodiscard]] std::uint32_t number() const { return system_; }
  [[nodiscard]] std::string title() const { return "robot " + std::to_string(system_); }
  [[nodiscard]] std::string name(tims::Address component) const {
    return client_.name_of(component);
  }
  // The address in the form that needs no quotes.
  [[nodiscard]] std::string plain_name(tims::Address component) const {
    return shell_name(component, client_.widths());
  }

  // The time since the last of its components was registered [s].
  [[nodiscard]] double settled_s() const { return settled_s_.at(system_); }

  // Sorted by instance.
  [[nodiscard]] const std::vector<tims::Address>& all(std::uint32_t class_id) const;
  [[nodiscard]] std::optional<tims::Address> first(std::uint32_t class_id) const;
  // Throws Failure; `hint` names the program to start.
  [[nodiscard]] tims::Address need(std::uint32_t class_id, const std::string& program) const;

  // "on", "off", "error", "silent"
  std::string state(tims::Address component);
  bool is_on(tims::Address component) { return state(component) == "on"; }
  // Empty on success, else the reason, which may be an empty string.
  std::optional<std::string> turn_on(tims::Address component);
  // Throws Failure.
  void need_on(tims::Address component);

  // The component selected by the parameters NAMESys and NAMEInst; empty: none.
  [[nodiscard]] std::optional<tims::Address> linked(const rack::ParameterList& parameters,
                                                    std::string_view name,
                                                    std::uint32_t class_id) const;

  // The path by which a component of this host opens a file that its parameter names, relative to
  // its working directory. The error states why the path is not known here.
  [[nodiscard]] tims::Result<std::filesystem::path> path_of(tims::Address component,
                                                            const std::string& file) const;

  // Empty if it is off or has no data of that time.
  template <typename Data>
  std::optional<Data> data(tims::Address component, rack::TimeStamp time = 0) {
    const Message answer = client_.ask(component, tims::type::kGetData, rack::GetDataRequest{time});
    if (answer.header.type != tims::type::kData) return std::nullopt;
    return value_or_fail(rack::decode<Data>(answer.view()), name(component));
  }

 private:
  void choose(const std::string& wanted, AdminClient& admin);

  ComponentClient client_;
  std::uint32_t system_ = 0;
  bool is_here_ = false;                             // the router is on this host
  std::map<tims::Address, std::int64_t> processes_;  // of components at the router
  std::map<std::uint32_t, std::map<std::uint32_t, std::vector<tims::Address>>> found_;  // by system
  std::map<std::uint32_t, double> settled_s_;                                           // likewise
};

// The value of a parameter; empty if it does not exist or has another type.
std::optional<std::int32_t> integer_of(const rack::ParameterList& list, std::string_view name);
std::optional<std::string> text_of(const rack::ParameterList& list, std::string_view name);
// Whether a Position knows the geographic position of its origin, by configuration or measurement.
// Otherwise, the first conversion would define the origin.
bool knows_earth(const rack::ParameterList& of_position);
double number_of(const rack::ParameterList& list, std::string_view name, double otherwise);

}  // namespace timsctl
