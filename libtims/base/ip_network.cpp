#include "base/ip_network.h"

#include <algorithm>
#include <string>

#include <arpa/inet.h>

#include "base/text.h"

namespace tims::base {
namespace {

constexpr unsigned kMappedBits = 96;  // before an IPv4 address
constexpr unsigned kBits = 128;

}  // namespace

std::optional<IpNetwork> IpNetwork::parse(std::string_view text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  const std::string address(text.substr(0, slash));
  if (address.find('\0') != std::string::npos) return std::nullopt;  // inet_pton stops there
  IpNetwork network;
  auto* const bytes = network.address_.data();
  const bool is_v4 = ::inet_pton(AF_INET, address.c_str(), bytes + kMappedBits / 8) == 1;
  if (is_v4)
    network.address_[10] = network.address_[11] = 0xFF;
  else if (::inet_pton(AF_INET6, address.c_str(), bytes) != 1)
    return std::nullopt;
  const unsigned before = is_v4 ? kMappedBits : 0;
  network.bits_ = kBits;
  if (slash == text.size()) return network;
  const auto length = parse_number<unsigned>(text.substr(slash + 1), 10);
  if (!length || *length > kBits - before) return std::nullopt;
  network.bits_ = before + *length;
  return network;
}

bool IpNetwork::contains(const IpNetwork& other) const {
  if (other.bits_ < bits_) return false;
  const unsigned whole = bits_ / 8;
  const unsigned rest = bits_ % 8;
  return std::equal(address_.begin(), address_.begin() + whole, other.address_.begin()) &&
         (rest == 0 || ((address_[whole] ^ other.address_[whole]) >> (8 - rest)) == 0);
}

}  // namespace tims::base
