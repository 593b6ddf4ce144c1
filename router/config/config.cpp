#include "router/config/config.h"

#include <algorithm>
#include <array>

#include <arpa/inet.h>
#include <fmt/core.h>

#include "base/text.h"

namespace tims::config {
namespace {

bool is_numeric(int family, const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  return ::inet_pton(family, host.c_str(), bytes.data()) == 1;
}

constexpr std::size_t kNameMax = 253;  // of a host in the DNS

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_name_character(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || c == '-' || c == '_';
}

// "fe80::1" or "fe80::1%eth0": a link-local address requires its interface.
bool is_v6(std::string_view host) {
  const std::size_t percent = host.find('%');
  if (percent != std::string_view::npos) {
    const std::string_view zone = host.substr(percent + 1);
    const auto fits = [](char c) {
      return is_name_character(c) || (c >= 'A' && c <= 'Z') || c == '.';
    };
    if (zone.empty() || !std::ranges::all_of(zone, fits)) return false;
  }
  return is_numeric(AF_INET6, std::string(host.substr(0, percent)));
}

// A malformed IPv4 address ("256.0.0.1") is not accepted as a name either.
bool is_name(std::string_view host) {
  if (host.empty() || host.size() > kNameMax) return false;
  if (std::ranges::all_of(host.substr(host.rfind('.') + 1), is_digit)) return false;
  while (!host.empty()) {
    const std::string_view label = host.substr(0, host.find('.'));
    if (label.empty() || !std::ranges::all_of(label, is_name_character)) return false;
    if (label.front() == '-' || label.back() == '-') return false;
    host.remove_prefix(std::min(host.size(), label.size() + 1));
  }
  return true;
}

// ":2010", or empty for the default; port 0 is not a valid destination.
std::optional<std::uint16_t> parse_port_behind(std::string_view text) {
  if (text.empty()) return kLinkPort;
  const auto port = base::parse_number<std::uint16_t>(text.substr(1));
  return port == 0 ? std::nullopt : port;
}

}  // namespace

std::optional<Endpoint> Endpoint::parse(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto port = base::parse_number<std::uint16_t>(text.substr(colon + 1));
  if (!port) return std::nullopt;

  std::string host(text.substr(0, colon));
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
    if (!is_numeric(AF_INET6, host)) return std::nullopt;
    return Endpoint{host, *port};
  }
  if (host == "localhost") host = "127.0.0.1";
  if (!is_numeric(AF_INET, host)) return std::nullopt;
  return Endpoint{host, *port};
}

bool Endpoint::loopback() const {
  if (in_addr v4{}; ::inet_pton(AF_INET, host.c_str(), &v4) == 1)
    return ntohl(v4.s_addr) >> 24 == IN_LOOPBACKNET;
  in6_addr v6{};
  return ::inet_pton(AF_INET6, host.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6) != 0;
}

std::string Endpoint::to_string() const {
  const bool v6 = host.find(':') != std::string::npos;
  return v6 ? fmt::format("[{}]:{}", host, port) : fmt::format("{}:{}", host, port);
}

std::optional<Destination> Destination::parse(std::string_view text) {
  if (text == "auto") return Destination{std::string(text), 0};
  const bool in_brackets = text.starts_with('[');
  const std::size_t end = text.find(in_brackets ? ']' : ':');
  if (in_brackets && end == std::string_view::npos) return std::nullopt;
  std::string_view port_text = text.substr(std::min(text.size(), end + (in_brackets ? 1 : 0)));
  if (!port_text.empty() && port_text.front() != ':') return std::nullopt;
  const auto port = parse_port_behind(port_text);
  if (!port) return std::nullopt;

  std::string host(in_brackets ? text.substr(1, end - 1) : text.substr(0, end));
  // An interface name after '%' is not a DNS name: its case is significant.
  if (in_brackets) return is_v6(host) ? std::optional(Destination{host, *port}) : std::nullopt;
  for (char& c : host)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (host == "localhost") host = "127.0.0.1";
  if (!is_numeric(AF_INET, host) && !is_name(host)) return std::nullopt;
  return Destination{host, *port};
}

bool Destination::loopback() const { return Endpoint{host, port}.loopback(); }

std::string Destination::to_string() const {
  return port == 0 ? host : Endpoint{host, port}.to_string();
}

std::vector<std::string> list_of(std::string_view text) {
  std::vector<std::string> items;
  while (!text.empty()) {
    std::string_view item = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), item.size() + 1));
    while (item.starts_with(' ')) item.remove_prefix(1);
    while (item.ends_with(' ')) item.remove_suffix(1);
    if (!item.empty()) items.emplace_back(item);
  }
  return items;
}

policy::PolicyText policy_text(const Config& config, const std::vector<std::string>& rule_places) {
  policy::PolicyText text;
  for (const Rule& rule : config.rules) {
    policy::RuleText& added = text.rules.emplace_back(rule);
    if (text.rules.size() <= rule_places.size()) added.place = rule_places[text.rules.size() - 1];
  }
  for (const Test& test : config.tests) text.tests.push_back(test);
  return text;
}

bool Link::uses(PathKind path) const { return std::ranges::find(paths, path) != paths.end(); }

std::string Link::to_string() const {
  if (!accepts()) return Destination{host, port}.to_string();
  if (!system) return fmt::format("{} of *", core::label(core::kLinkKinds, kind).name);
  return fmt::format("{} of system {}", core::label(core::kLinkKinds, kind).name, *system);
}

}  // namespace tims::config
