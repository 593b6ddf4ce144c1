// Parameters of a component: asked for, and shown.
#pragma once

#include <string>

#include "proxies/generic.h"
#include "tools/timsctl/component_call.h"
#include "tools/timsctl/render.h"

namespace timsctl {

rack::ParameterList get_parameters(ComponentCall& call, tims::Address component);

json::object parameter_json(const rack::Parameter& parameter);
// Of those objects.
std::string parameter_table(const json::array& items, const Look& look);

}  // namespace timsctl
