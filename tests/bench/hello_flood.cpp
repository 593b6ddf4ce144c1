#include "tests/bench/hello_flood.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <thread>
#include <vector>

#include <sys/socket.h>

#include "libtims/os/clock.h"
#include "router/core/random.h"
#include "router/link/datagram.h"
#include "tests/bench/addresses.h"
#include "tests/bench/metrics.h"
#include "tests/bench/two_hosts.h"
#include "tests/bench/udp.h"

namespace tims::bench {
namespace {

constexpr std::uint64_t kBurstsPerSecond = 1000;
constexpr Duration kBurstEvery = std::chrono::milliseconds(1);
constexpr Duration kBeyond = std::chrono::seconds(1);  // it begins before the measurement does

class HelloFlood {
 public:
  HelloFlood(const os::File& socket, const sockaddr_in& to, std::size_t burst)
      : socket_(socket), to_(to), bytes_(burst), parts_(burst), messages_(burst) {
    for (std::size_t i = 0; i < burst; ++i) {
      parts_[i].iov_base = bytes_[i].data();
      messages_[i].msg_hdr.msg_name = &to_;
      messages_[i].msg_hdr.msg_namelen = sizeof to_;
      messages_[i].msg_hdr.msg_iov = &parts_[i];
      messages_[i].msg_hdr.msg_iovlen = 1;
    }
  }

  // Returns how many the kernel took.
  std::size_t send_burst() {
    for (std::size_t i = 0; i < bytes_.size(); ++i) parts_[i].iov_len = put_hello(bytes_[i], i);
    const int sent =
        ::sendmmsg(socket_.get(), messages_.data(), static_cast<unsigned>(messages_.size()), 0);
    return sent > 0 ? static_cast<std::size_t>(sent) : 0;
  }

 private:
  using Datagram = std::array<std::byte, link::kControlDatagramMax>;

  std::size_t put_hello(Datagram& to, std::size_t number) {
    const std::uint64_t token = core::next_random(random_) | 1;
    if (number % 2 == 0) return link::encode(link::SealedHello{token}, to);
    return link::encode(link::Hello{.version_min = link::kVersionPlain,
                                    .version_max = link::kVersionPlain,
                                    .kind = core::LinkKind::kSuper,
                                    .token = token,
                                    .keep_alive = std::chrono::milliseconds(300),
                                    .identity = {.epoch = token,
                                                 .role = core::Role::kSystem,
                                                 .system = 77,
                                                 .id = 1,
                                                 .name = std::string_view("nobody"),
                                                 .message_max = 1U << 20}},
                        to);
  }

  const os::File& socket_;
  sockaddr_in to_;
  std::uint64_t random_ = 1;
  std::vector<Datagram> bytes_;
  std::vector<iovec> parts_;
  std::vector<mmsghdr> messages_;
};

}  // namespace

bool send_hello_flood(const Plan& plan) {
  const auto socket = open_udp(plan.host + ":0");
  const auto to = udp_address(TwoHosts::address(TwoHosts::Side::kBase) + kRouterPort);
  if (!socket || !to) {
    std::fprintf(stderr, "flood: %s\n", (socket ? to.error() : socket.error()).message().c_str());
    return false;
  }
  HelloFlood flood(*socket, *to, plan.count / kBurstsPerSecond);
  const Time began = os::now();
  const Time until = began + plan.seconds + kBeyond;
  std::size_t sent = 0;
  for (Time next = began; next < until; next += kBurstEvery) {
    std::this_thread::sleep_for(next - os::now());
    sent += flood.send_burst();
  }
  const double seconds = std::chrono::duration<double>(os::now() - began).count();
  print_metric("flood_per_s", static_cast<double>(sent) / seconds);
  return true;
}

}  // namespace tims::bench
