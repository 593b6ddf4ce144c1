// A robot as `timsctl nav` sees it: which components of it say where it is, plan and drive. They
// are found by their classes, and how they hang together by their parameters (pathSys, pathInst).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rack/proxies/generic.h"
#include "rack/proxies/geometry.h"
#include "tools/timsctl/component_client.h"

namespace timsctl {

// What people read: m, and degrees clockwise from x (north), 0 to 360.
json::object pose_json(const rack::Position3d& pos);
std::string place_text(double x_m, double y_m);
double metres(rack::Millimetres<rack::i32> length);
// "0.03 s", of data of this time; the clocks of two hosts may differ.
double age_s(rack::TimeStamp recorded);

class NavRobot {
 public:
  // `wanted`: a system's number or the name of a router; empty: --robot, or the only robot there
  // is. Throws Failure.
  explicit NavRobot(Context& context, std::string wanted = {});

  [[nodiscard]] ComponentClient& client() { return client_; }
  [[nodiscard]] std::uint32_t number() const { return system_; }
  [[nodiscard]] std::string title() const { return "robot " + std::to_string(system_); }
  [[nodiscard]] std::string name(tims::Address component) const {
    return client_.name_of(component);
  }
  // As timsctl takes it without quotes.
  [[nodiscard]] std::string plain_name(tims::Address component) const {
    return shell_name(component, client_.widths());
  }

  // In the order of their instances.
  [[nodiscard]] const std::vector<tims::Address>& all(std::uint32_t class_id) const;
  [[nodiscard]] std::optional<tims::Address> first(std::uint32_t class_id) const;
  // Throws Failure: `hint` says what to start.
  [[nodiscard]] tims::Address need(std::uint32_t class_id, const std::string& program) const;

  // "on", "off", "error", "silent"
  std::string state(tims::Address component);
  bool is_on(tims::Address component) { return state(component) == "on"; }
  // Nothing: it is on now. Else why not; empty when it has no words for it.
  std::optional<std::string> turn_on(tims::Address component);
  // Throws Failure.
  void need_on(tims::Address component);

  // Another component, of which the parameters NAMESys and NAMEInst say which; nothing: none.
  [[nodiscard]] std::optional<tims::Address> linked(const rack::ParameterList& parameters,
                                                    std::string_view name,
                                                    std::uint32_t class_id) const;

  // Nothing when it is off, or has none of that time.
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
  std::map<std::uint32_t, std::map<std::uint32_t, std::vector<tims::Address>>> found_;  // by system
};

// Of a parameter; nothing when there is none, or it is of another type.
std::optional<std::int32_t> integer_of(const rack::ParameterList& list, std::string_view name);
std::optional<std::string> text_of(const rack::ParameterList& list, std::string_view name);
// Of a Position: whether it was told, or has found out, where on Earth its origin lies. Before, the
// first place that it is asked about would become that.
bool knows_earth(const rack::ParameterList& of_position);
double number_of(const rack::ParameterList& list, std::string_view name, double otherwise);

}  // namespace timsctl
