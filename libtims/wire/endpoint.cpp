#include "wire/endpoint.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace tims::wire {

namespace {

Error no_endpoint(std::string_view text, std::string_view problem) {
  return {Errc::kInvalidArgument,
          "\"" + std::string(text) + "\" names no router: " + std::string(problem) +
              "; write unix:PATH, /PATH, HOST:PORT, [IPv6]:PORT or tls:HOST:PORT[/NAME]"};
}

std::optional<std::uint16_t> port_of(std::string_view text) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || port == 0) return std::nullopt;
  return port;
}

// `rest`: the text after the host, "" or ":PORT".
Result<Endpoint> tcp_endpoint(std::string_view text, std::string_view host, std::string_view rest) {
  if (host.empty()) return no_endpoint(text, "it has no host");
  if (rest.empty()) return Endpoint(TcpEndpoint{.host = std::string(host)});
  const auto port = rest.starts_with(':') ? port_of(rest.substr(1)) : std::nullopt;
  if (!port) return no_endpoint(text, "a port is a number from 1 to 65535");
  return Endpoint(TcpEndpoint{std::string(host), *port});
}

}  // namespace

Result<Endpoint> parse_endpoint(std::string_view text) {
  constexpr std::string_view kUnix = "unix:";
  constexpr std::string_view kTls = "tls:";
  if (text.starts_with(kTls)) {
    const std::string_view place = text.substr(kTls.size());
    const std::size_t slash = std::min(place.find('/'), place.size());
    auto endpoint = parse_endpoint(place.substr(0, slash));
    if (!endpoint) return endpoint;
    auto* tcp = std::get_if<TcpEndpoint>(&*endpoint);
    if (tcp == nullptr || tcp->tls) return no_endpoint(text, "TLS leads to a HOST:PORT");
    tcp->tls = true;
    if (slash == place.size()) return endpoint;
    tcp->name = place.substr(slash + 1);
    if (tcp->name.empty() || tcp->name.find('/') != std::string::npos)
      return no_endpoint(text, "behind the / stands the name of a router");
    return endpoint;
  }
  if (text.starts_with(kUnix)) {
    if (text.size() == kUnix.size()) return no_endpoint(text, "it has no path");
    return Endpoint(UnixEndpoint{std::string(text.substr(kUnix.size()))});
  }
  if (text.starts_with('/') || text.starts_with("./") || text.starts_with("../"))
    return Endpoint(UnixEndpoint{std::string(text)});
  if (text.find('/') != std::string_view::npos)
    return no_endpoint(text, "a host has no / in its name");
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) return no_endpoint(text, "the ] is missing");
    return tcp_endpoint(text, text.substr(1, end - 1), text.substr(end + 1));
  }
  if (std::ranges::count(text, ':') > 1) return tcp_endpoint(text, text, "");  // IPv6
  const std::size_t colon = std::min(text.find(':'), text.size());
  return tcp_endpoint(text, text.substr(0, colon), text.substr(colon));
}

std::string to_string(const TcpEndpoint& endpoint) {
  const bool v6 = endpoint.host.find(':') != std::string::npos;
  const std::string host = v6 ? "[" + endpoint.host + "]" : endpoint.host;
  return (endpoint.tls ? "tls:" : "") + host + ":" + std::to_string(endpoint.port) +
         (endpoint.name.empty() ? "" : "/" + endpoint.name);
}

std::string to_string(const Endpoint& endpoint) {
  if (const auto* tcp = std::get_if<TcpEndpoint>(&endpoint)) return to_string(*tcp);
  return std::get<UnixEndpoint>(endpoint).path;
}

}  // namespace tims::wire
