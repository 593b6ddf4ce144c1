#include "router/io/http/origin.h"

#include <algorithm>
#include <array>
#include <string>

#include <arpa/inet.h>

#include "router/config/config.h"

namespace tims::io {
namespace {

bool is_port(std::string_view text) {
  return !text.empty() && text.size() <= 5 &&
         std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

// The host of "host", "host:port", "[::1]" and "[::1]:port", without brackets; empty when the text
// is none of these.
std::string host_of(std::string_view text) {
  const bool bracketed = text.starts_with('[');
  const std::size_t end = bracketed ? text.find(']') : text.find(':');
  std::string_view host = text.substr(0, end);
  std::string_view rest = text.substr(std::min(end, text.size()));
  if (bracketed) {
    if (rest.empty()) return {};
    host.remove_prefix(1);
    rest.remove_prefix(1);
  }
  const bool well_formed = rest.empty() || (rest.front() == ':' && is_port(rest.substr(1)));
  if (!well_formed || (host.find(':') != std::string_view::npos) != bracketed) return {};
  return std::string(host);
}

bool is_numeric(const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  return ::inet_pton(AF_INET, host.c_str(), bytes.data()) == 1 ||
         ::inet_pton(AF_INET6, host.c_str(), bytes.data()) == 1;
}

bool is_localhost(std::string_view host) {
  return std::ranges::equal(host, std::string_view("localhost"), [](char a, char b) {
    return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b;
  });
}

}  // namespace

bool is_safe_host(std::string_view host) {
  const std::string name = host_of(host);
  return is_localhost(name) || is_numeric(name);
}

bool is_loopback_origin(std::string_view origin) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!origin.starts_with(scheme)) continue;
    const std::string name = host_of(origin.substr(scheme.size()));
    return is_localhost(name) || config::Endpoint{name, 0}.loopback();
  }
  return false;
}

}  // namespace tims::io
