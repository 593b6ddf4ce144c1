#include "security/keys/dialled.h"

#include <algorithm>
#include <array>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.h"

namespace tims::security {
namespace {

// A numeric address as bytes: 4 or 16, without the name of an interface ("fe80::1%eth0"). Empty: it
// is a name.
std::string address_of(const std::string& host) {
  const std::string text = host.substr(0, host.find('%'));
  std::array<char, 16> bytes{};
  if (::inet_pton(AF_INET, text.c_str(), bytes.data()) == 1) return {bytes.data(), 4};
  if (::inet_pton(AF_INET6, text.c_str(), bytes.data()) == 1) return {bytes.data(), bytes.size()};
  return {};
}

bool is_same_host(const std::string& a, const std::string& b) {
  const std::string address = address_of(a);
  return address.empty() ? base::lower(a) == base::lower(b) : address == address_of(b);
}

bool is_loopback(const std::string& host) {
  constexpr std::array<char, 16> kLoopback6{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  const std::string address = address_of(host);
  if (address.empty()) return base::lower(host) == "localhost";
  return address.size() == 4 ? address.front() == 127 : std::ranges::equal(address, kLoopback6);
}

}  // namespace

std::optional<Refusal> judge_dialled(const Dialled& dialled, const Certificate& certificate) {
  const auto identity = Identity::parse(certificate.uris());
  const auto refused = [](std::string text) {
    return Refusal{Refusal::Code::kIdentity, std::move(text)};
  };
  if (!identity) return refused(identity.error().detail());
  if (identity->role == MemberRole::kUser)
    return refused(
        fmt::format("the certificate there is that of {}, not of a router", identity->to_string()));
  if (!dialled.name.empty()) {
    if (identity->name == dialled.name) return std::nullopt;
    return refused(fmt::format("the router there is {}, not \"{}\"", identity->to_string(),
                               base::printable(dialled.name)));
  }
  const auto names = certificate.host_names();
  if (is_loopback(dialled.host) || std::ranges::any_of(names, [&](const std::string& name) {
        return is_same_host(dialled.host, name);
      }))
    return std::nullopt;
  return refused(fmt::format(
      "the router there is {}, and its certificate is for {}, not for {}: if it is the one that "
      "you mean, write HOST:PORT/{}",
      identity->to_string(),
      names.empty() ? "no address" : base::printable(fmt::format("{}", fmt::join(names, ", "))),
      base::printable(dialled.host), identity->name));
}

TlsSettings dialling_settings(const Credentials& own, Dialled dialled) {
  return client_settings(own, [dialled = std::move(dialled)](const Certificate& server) {
    return judge_dialled(dialled, server);
  });
}

}  // namespace tims::security
