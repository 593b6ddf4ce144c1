#include "router/io/http/origin.h"

#include <algorithm>
#include <array>
#include <string>

#include <arpa/inet.h>
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

bool is_same(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::ranges::equal(a, b, {}, lower, lower);
}

// "robot7:3000" of "http://robot7:3000"; empty when it is none.
std::string_view host_field_of(std::string_view origin) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!origin.starts_with(scheme)) continue;
    const std::string_view host = origin.substr(scheme.size());
    return host_of(host).empty() ? std::string_view() : host;
  }
  return {};
}

}  // namespace

bool is_safe_host(std::string_view host, std::span<const std::string> origins) {
  const std::string name = host_of(host);
  if (name.empty()) return false;
  return is_same(name, "localhost") || is_numeric(name) ||
         std::ranges::any_of(origins, [&](const std::string& origin) {
           return is_same(host_of(host_field_of(origin)), name);
         });
}

bool is_safe_origin(std::string_view origin, std::string_view host,
                    std::span<const std::string> origins) {
  const std::string_view its_host = host_field_of(origin);
  if (its_host.empty()) return false;
  return is_same(its_host, host) || std::ranges::any_of(origins, [&](const std::string& listed) {
           return is_same(listed, origin);
         });
}

}  // namespace tims::io
