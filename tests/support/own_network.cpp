#include "tests/support/own_network.h"

#include <fcntl.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include "tests/support/two_networks.h"

namespace tims::test {
namespace {

Result<void> configure_loopback(unsigned long request, ifreq settings) {
  settings.ifr_name[0] = 'l';
  settings.ifr_name[1] = 'o';
  const os::File socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (::ioctl(socket.get(), request, &settings) != 0) return os::system_error("loopback");
  return {};
}

}  // namespace

Result<OwnNetwork> OwnNetwork::enter() {
  os::File before(::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC));
  if (!before) return os::system_error("/proc/thread-self/ns/net");
  if (::unshare(CLONE_NEWNET) != 0)
    return os::system_error("cannot create a network namespace (needs root)");
  OwnNetwork network(std::move(before));
  ifreq up{};
  up.ifr_flags = IFF_UP;
  if (auto done = configure_loopback(SIOCSIFFLAGS, up); !done) return done.error();
  return network;
}

Result<OwnNetwork> OwnNetwork::enter_with(const std::string& address) {
  auto network = enter();
  if (!network) return network;
  if (auto added = TwoNetworks::run("ip address add " + address + "/32 dev lo"); !added)
    return added.error();
  return network;
}

OwnNetwork::~OwnNetwork() {
  if (before_) ::setns(before_.get(), CLONE_NEWNET);
}

Result<void> OwnNetwork::set_loopback_mtu(int bytes) {
  ifreq mtu{};
  mtu.ifr_mtu = bytes;
  return configure_loopback(SIOCSIFMTU, mtu);
}

}  // namespace tims::test
