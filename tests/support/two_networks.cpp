#include "tests/support/two_networks.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sched.h>
#include <unistd.h>

#include "tests/support/child_process.h"

namespace tims::test {
namespace {

os::File this_network() {
  return os::File(::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC));
}

}  // namespace

NetworkVisit::NetworkVisit(const os::File& there, const os::File& home) : back(home) {
  ::setns(there.get(), CLONE_NEWNET);
}
NetworkVisit::~NetworkVisit() { ::setns(back.get(), CLONE_NEWNET); }

Result<TwoNetworks> TwoNetworks::enter() {
  auto outer = OwnNetwork::enter();
  if (!outer) return outer.error();
  TwoNetworks networks(std::move(*outer));
  networks.right_ = this_network();
  if (::unshare(CLONE_NEWNET) != 0) return os::system_error("cannot create a network namespace");
  networks.left_ = this_network();
  if (auto joined = networks.join(); !joined) return joined.error();
  return networks;
}

Result<void> TwoNetworks::join() {
  auto done =
      run(fmt::format("ip link set lo up\n"
                      "ip link add cable type veth peer name other\n"
                      "ip link set other netns /proc/{}/fd/{}\n"
                      "ip address add {}/24 dev cable\n"
                      "ip link set cable up",
                      ::getpid(), right_.get(), kLeft));
  if (!done) return done;
  return on_the_right([] {
    return run(
        fmt::format("ip link set other name cable\n"
                    "ip address add {}/24 dev cable\n"
                    "ip link set cable up",
                    kRight));
  });
}

Result<void> HiddenNetwork::hide_behind(const TwoNetworks& networks) {
  left_ = this_network();
  const bool is_apart = networks.on_the_right([this] {
    const bool done = ::unshare(CLONE_NEWNET) == 0;
    hidden_ = this_network();
    return done;
  });
  if (!is_apart) return Error(Errc::kSystem, "cannot create a network namespace");
  auto routes = networks.on_the_right([this] {
    return TwoNetworks::run(
        fmt::format("ip link add inside type veth peer name outside\n"
                    "ip link set outside netns /proc/{}/fd/{}\n"
                    "ip address add 192.168.78.1/24 dev inside\n"
                    "ip link set inside up\n"
                    "echo 1 >/proc/sys/net/ipv4/ip_forward\n"
                    "nft add table ip nat\n"
                    "nft add chain ip nat out '{{ type nat hook postrouting priority 100; }}'\n"
                    "nft add rule ip nat out oifname cable masquerade",
                    ::getpid(), hidden_.get()));
  });
  if (!routes) return routes;
  return inside([] {
    return TwoNetworks::run(
        fmt::format("ip link set lo up\n"
                    "ip address add {}/24 dev outside\n"
                    "ip link set outside up\n"
                    "ip route add default via 192.168.78.1",
                    kAddress));
  });
}

Result<void> TwoNetworks::run(const std::string& commands) {
  auto child = ChildProcess::start({"sh", "-ec", commands});
  if (!child) return child.error();
  const auto status = child->wait();
  if (!status) return status.error();
  if (status->success()) return {};
  return Error(Errc::kSystem, commands + ": " + child->output());
}

}  // namespace tims::test
