#include "router/io/dds/locator.h"

#include <algorithm>

#include <fastrtps/utils/IPLocator.h>

namespace tims::io {
namespace {

constexpr std::size_t kIpv4At = 12;  // of a locator's sixteen bytes

}  // namespace

Locator locator_at(const std::string& host, std::uint16_t port) {
  Locator locator;
  eprosima::fastrtps::rtps::IPLocator::createLocator(LOCATOR_KIND_UDPv4, host, port, locator);
  return locator;
}

Locator locator_of(const link::NetAddress& address) {
  Locator locator;
  locator.kind = LOCATOR_KIND_UDPv4;
  locator.port = address.port;
  std::copy_n(address.ip.end() - 4, 4, locator.address + kIpv4At);
  return locator;
}

link::NetAddress address_of(const Locator& locator) {
  const auto* ip = locator.address + kIpv4At;
  return link::NetAddress::v4(ip[0], ip[1], ip[2], ip[3], static_cast<std::uint16_t>(locator.port));
}

}  // namespace tims::io
