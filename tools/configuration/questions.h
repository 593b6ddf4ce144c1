// Reads the questions of PROTOCOL.md: what is wrong with one is refused with its error. Pure.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tims/result.h"
#include "tims/time.h"
#include "tools/configuration/fleet.h"
#include "tools/configuration/folder.h"
#include "tools/configuration/host_change.h"
#include "tools/configuration/robot_check.h"

namespace timsctl::configuration {

// An error of PROTOCOL.md, with the findings that explain it.
struct Refuse {
  std::string code;
  std::string message;
  std::vector<Finding> findings{};
};

void refuse_if(const Refused& refused);

template <typename T>
T need(tims::Result<T> result, const std::string& code) {
  if (!result) throw Refuse{code, result.error().detail()};
  return std::move(result).value();
}

// All of these throw Refuse.
std::string checked_text(const json::object& question, std::string_view name);  // who, why
std::string change_id(const json::object& question);
// `usual`: when the question states none.
tims::Duration seconds_in(const json::object& question, std::string_view name, double usual,
                          double min, double max);
Generation generation_in(const json::object& question, std::string_view name);
std::string file_in(const json::object& question);
// Addresses of the agents of the other hosts of a change.
std::vector<std::string> others_in(const json::object& question);
// The files after the edits of a question.
Texts edited(const json::object& question, const Texts& before);
// All files of all hosts, of conf_fleet.
std::vector<FleetHost> hosts_in(const json::object& question);

}  // namespace timsctl::configuration
