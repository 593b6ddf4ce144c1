// The limit between two hosts: messages as a stream of bare datagrams, straight to the other end or
// to a relay. What is lost is lost, and the stream with it: buffers are larger than windows.
#pragma once

#include <sys/socket.h>

#include "tests/bench/addresses.h"
#include "tests/bench/message_stream.h"
#include "tests/bench/udp.h"

namespace tims::bench {

class UdpLink final : public MessageStream {
 public:
  static Result<UdpLink> open(const Plan& plan) {
    auto socket = open_udp(plan.host + kClientPort);
    if (!socket) return socket.error();
    const auto to = udp_address(plan.endpoint);
    if (!to) return to.error();
    if (::connect(socket->get(), reinterpret_cast<const sockaddr*>(&*to), sizeof *to) != 0)
      return os::system_error("UDP to " + plan.endpoint);
    return UdpLink(plan, std::move(*socket));
  }

  [[nodiscard]] bool needs_credit() const { return true; }

 private:
  static constexpr std::size_t kGather = 62 << 10;  // with one more small message it is a train

  UdpLink(const Plan& plan, os::File socket) : MessageStream(plan, std::move(socket), kGather) {}
  bool write(std::span<const std::byte> first, std::span<const std::byte> second) override {
    return send_trains(socket(), first, second);
  }
};

}  // namespace tims::bench
