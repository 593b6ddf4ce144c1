// Parameters of a component: asked for, and shown.
#pragma once

#include <optional>
#include <string>

#include "rack/proxies/generic.h"
#include "tools/timsctl/component_call.h"
#include "tools/timsctl/render.h"

namespace timsctl {

rack::ParameterList get_parameters(ComponentCall& call, tims::Address component);

// When new values take effect, as the component says; an original one does not.
std::optional<rack::ParameterEffects> get_effects(ComponentCall& call, tims::Address component);
std::optional<rack::TakesEffect> effect_of(const std::optional<rack::ParameterEffects>& effects,
                                           std::string_view name);

json::object parameter_json(const rack::Parameter& parameter,
                            const std::optional<rack::ParameterEffects>& effects);
// Of those objects.
std::string parameter_table(const json::array& items, const Look& look);

}  // namespace timsctl
