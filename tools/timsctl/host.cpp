#include "tools/timsctl/host.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

Failure no_host(std::string_view text) {
  return usage_error(fmt::format("\"{}\" names no router", text),
                     "HOST, HOST:PORT, [IPv6]:PORT or unix:PATH");
}

TcpHost with_port(std::string_view text, std::string_view name, std::string_view port) {
  const auto number = parse_count(port);
  if (name.empty() || !number || *number == 0 || *number > 65535) throw no_host(text);
  return {std::string(name), std::string(port)};
}

}  // namespace

Host parse_host(std::string_view text) {
  constexpr std::string_view kUnix = "unix:";
  if (text.starts_with(kUnix)) text.remove_prefix(kUnix.size());
  if (text.starts_with('/') || text.starts_with("./")) return UnixHost{std::string(text)};
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) throw no_host(text);
    const std::string_view name = text.substr(1, end - 1);
    const std::string_view rest = text.substr(end + 1);
    if (rest.empty()) return with_port(text, name, "2000");
    if (!rest.starts_with(':')) throw no_host(text);
    return with_port(text, name, rest.substr(1));
  }
  const auto colons = std::ranges::count(text, ':');
  if (colons != 1) return with_port(text, text, "2000");  // a name, or an IPv6 address
  const std::size_t colon = text.find(':');
  return with_port(text, text.substr(0, colon), text.substr(colon + 1));
}

std::string to_string(const Host& host) {
  if (const auto* tcp = std::get_if<TcpHost>(&host)) return tcp->to_string();
  return std::get<UnixHost>(host).path;
}

}  // namespace timsctl
