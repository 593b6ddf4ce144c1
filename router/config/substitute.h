// ${NAME} in a text becomes the environment's value; $$ becomes a dollar sign.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "tims/result.h"

namespace tims::config {

using Environment = std::map<std::string, std::string, std::less<>>;

// An unknown variable or an unclosed brace is an error that names it.
Result<std::string> substitute(std::string_view text, const Environment& environment);

}  // namespace tims::config
