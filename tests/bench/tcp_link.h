// libtims' client of the original protocol over TCP. The same client is used with the router and
// with the bare relay, so that only the part between differs. Small messages of a stream are
// collected, large ones are sent without copying, and received ones are read in place.
#pragma once

#include "client/tcp_client.h"
#include "tests/bench/blocking_socket.h"
#include "tests/bench/link.h"
#include "tests/bench/plan.h"

namespace tims::bench {

class TcpLink {
 public:
  enum class Between { kRouter, kRelay };

  // Connects and registers its mailbox.
  static Result<TcpLink> open(const Plan& plan, Between between);

  // With a slow reader the router drops messages, whereas the relay blocks the sender.
  [[nodiscard]] bool needs_credit() const { return between_ == Between::kRouter; }

  bool send(std::span<const std::byte> payload) {
    if (kHeaderSize + payload.size() > gather_ / 2)
      return client_.send(header_, payload, kNever).ok();
    client_.protocol().put(header_, payload);
    if (client_.protocol().unsent().size() >= gather_) flush();
    return true;
  }
  void flush() { (void)client_.flush(); }

  template <typename Deliver>
  void receive(Duration timeout, Deliver deliver) {
    flush();
    if (timeout != timeout_) set_read_timeout(client_.socket(), timeout_ = timeout);
    (void)client_.read([&](const Header& header, std::span<const std::byte> body) {
      if (!wire::is_router_message(header)) deliver(body);
    });
  }

 private:
  TcpLink(const Plan& plan, Between between, client::TcpClient client);

  client::TcpClient client_;
  Between between_;
  Header header_;  // of the messages
  std::size_t gather_;
  Duration timeout_{};
};

}  // namespace tims::bench
