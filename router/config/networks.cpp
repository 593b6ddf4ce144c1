#include "router/config/networks.h"

#include <algorithm>
#include <optional>
#include <string>

#include <arpa/inet.h>

#include "base/text.h"
#include "router/config/config.h"

namespace tims::config {
namespace {

using Bytes16 = std::array<std::uint8_t, 16>;

constexpr unsigned kMappedBits = 96;  // before an IPv4 address

std::optional<Bytes16> address_of(const std::string& text, bool& is_v4) {
  Bytes16 bytes{};
  is_v4 = ::inet_pton(AF_INET, text.c_str(), bytes.data() + 12) == 1;
  if (is_v4) {
    bytes[10] = bytes[11] = 0xFF;
    return bytes;
  }
  if (::inet_pton(AF_INET6, text.c_str(), bytes.data()) == 1) return bytes;
  return std::nullopt;
}

bool same_bits(const Bytes16& a, const Bytes16& b, unsigned bits) {
  const unsigned whole = bits / 8;
  if (!std::equal(a.begin(), a.begin() + whole, b.begin())) return false;
  const unsigned rest = bits % 8;
  return rest == 0 || ((a[whole] ^ b[whole]) >> (8 - rest)) == 0;
}

}  // namespace

Result<Networks> Networks::parse(std::string_view list) {
  Networks networks;
  for (const std::string& item : list_of(std::string(list))) {
    if (item == "loopback") {
      networks.networks_.push_back(*parse_one("127.0.0.0/8"));
      networks.networks_.push_back(*parse_one("::1"));
      continue;
    }
    auto network = parse_one(item);
    if (!network) return network.error();
    networks.networks_.push_back(*network);
  }
  return networks;
}

Result<Networks::Network> Networks::parse_one(const std::string& text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  bool is_v4 = false;
  const auto address = address_of(text.substr(0, slash), is_v4);
  const unsigned most = is_v4 ? 32 : 128;
  const auto bits = slash == text.size() ? std::optional(most)
                                         : base::parse_number<unsigned>(text.substr(slash + 1), 10);
  if (!address || !bits || *bits > most)
    return Error(Errc::kInvalidArgument,
                 "\"" + text +
                     "\" is not a network: write \"loopback\", \"10.9.0.0/16\" or "
                     "\"fd00::/8\", separated by commas");
  return Network{*address, *bits + (is_v4 ? kMappedBits : 0)};
}

bool Networks::contains(std::string_view endpoint) const {
  const std::size_t colon = std::min(endpoint.rfind(':'), endpoint.size());
  std::string host(endpoint.substr(0, colon));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  host.resize(std::min(host.find('%'), host.size()));
  bool is_v4 = false;
  const auto address = address_of(host, is_v4);
  return address && std::ranges::any_of(networks_, [&](const Network& network) {
           return same_bits(*address, network.address, network.bits);
         });
}

}  // namespace tims::config
