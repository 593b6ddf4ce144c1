#include "router/io/net/own_addresses.h"

#include <algorithm>
#include <memory>

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include "router/io/net/system_address.h"

namespace tims::io {
namespace {

using link::NetAddress;

bool is_any(const NetAddress& address) {
  const auto& ip = address.ip;
  const auto last = address.is_v4() ? ip.begin() + 12 : ip.begin();
  return std::all_of(last, ip.end(), [](std::uint8_t byte) { return byte == 0; });
}

}  // namespace

std::vector<NetAddress> own_addresses(const NetAddress& local) {
  if (!is_any(local)) return {local};
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(list, ::freeifaddrs);
  std::vector<NetAddress> outside;
  std::vector<NetAddress> loopback;
  for (const ifaddrs* at = list; at != nullptr; at = at->ifa_next) {
    if (at->ifa_addr == nullptr || (at->ifa_flags & IFF_RUNNING) == 0) continue;
    const int family = at->ifa_addr->sa_family;
    if (family != AF_INET && (family != AF_INET6 || local.is_v4())) continue;
    NetAddress address = net_address(*at->ifa_addr);
    address.port = local.port;
    if (address.scope != 0) continue;
    ((at->ifa_flags & IFF_LOOPBACK) != 0 ? loopback : outside).push_back(address);
  }
  std::vector<NetAddress>& found = outside.empty() ? loopback : outside;
  std::ranges::sort(found);
  return found;
}

}  // namespace tims::io
