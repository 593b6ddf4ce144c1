// Texts made from the table of verbs.
#pragma once

#include <string>
#include <string_view>

#include "tools/timsctl/verbs.h"

namespace timsctl {

std::string_view own_version();
std::string version_text();
std::string overview();
std::string noun_help(std::string_view noun);
std::string verb_help(const Verb& verb);
bool is_single(std::string_view noun);  // a command without verbs: "ping"

}  // namespace timsctl
