#include "router/config/substitute.h"

namespace tims::config {

Result<std::string> substitute(std::string_view text, const Environment& environment) {
  std::string out;
  while (!text.empty()) {
    const std::size_t plain = std::min(text.find('$'), text.size());
    out += text.substr(0, plain);
    text.remove_prefix(plain);
    if (text.starts_with("${")) {
      const std::size_t close = text.find('}');
      if (close == std::string_view::npos)
        return Error(Errc::kInvalidArgument, "has ${ without }; a dollar sign is written $$");
      const std::string_view name = text.substr(2, close - 2);
      const auto found = environment.find(name);
      if (found == environment.end())
        return Error(Errc::kInvalidArgument,
                     "names the environment variable " + std::string(name) + ", which is not set");
      out += found->second;
      text.remove_prefix(close + 1);
    } else if (!text.empty()) {
      out += '$';
      text.remove_prefix(text.starts_with("$$") ? 2 : 1);
    }
  }
  return out;
}

}  // namespace tims::config
