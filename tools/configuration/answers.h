// What the answers of PROTOCOL.md are made of. Pure.
#pragma once

#include <string>
#include <vector>

#include "base/text.h"
#include "tools/cli/output.h"
#include "tools/configuration/fleet.h"
#include "tools/configuration/folder.h"
#include "tools/configuration/robot_check.h"

namespace timsctl::configuration {

json::object to_json(const Finding& finding);
json::array to_json(const std::vector<Finding>& findings);
json::object to_json(const Edge& edge);
json::object to_json(const LinkBudget& link);
// "robots/scout.toml:12:44: maxRange must be ..."
std::string sentence_of(const Finding& finding);
json::array files_json(const Texts& files, bool with_text);
// Adds the values of a text and their places, as of conf_get.
void append_values(const base::TextFile& file, json::object& row);
// conf_options
json::object options_json();

}  // namespace timsctl::configuration
