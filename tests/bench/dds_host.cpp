#include "tests/bench/dds_host.h"

#include <thread>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>

#include "libtims/os/clock.h"

namespace tims::bench {
namespace {

bool runs(const std::string& address) {
  in_addr wanted{};
  ifaddrs* all = nullptr;
  if (::inet_pton(AF_INET, address.c_str(), &wanted) != 1 || ::getifaddrs(&all) != 0) return true;
  bool found = false;
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    const auto* here = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    found |= here->sin_addr.s_addr == wanted.s_addr && (one->ifa_flags & IFF_RUNNING) != 0;
  }
  ::freeifaddrs(all);
  return found;
}

}  // namespace

void wait_for_interface(const std::string& address) {
  constexpr Duration kPatience = std::chrono::seconds(5);
  constexpr Duration kLookEvery = std::chrono::milliseconds(10);
  for (const Time give_up = os::now() + kPatience; !runs(address) && os::now() < give_up;)
    std::this_thread::sleep_for(kLookEvery);
}

}  // namespace tims::bench
