#include "tests/bench/tcp_link.h"

#include "tests/bench/tcp_bytes.h"
#include "tests/support/tcp_socket.h"

namespace tims::bench {

Result<TcpLink> TcpLink::open(const Plan& plan, Between between) {
  auto socket = test::connect_tcp(plan.endpoint, std::chrono::seconds(5));
  if (!socket) return socket.error();
  make_blocking(*socket);
  TcpLink link(plan, between, std::move(*socket));
  auto registered = link.register_mailbox();
  if (!registered) return registered.error();
  return link;
}

// As the original's C library: no watchdog, then the mailbox, then one answer.
Result<void> TcpLink::register_mailbox() {
  const auto request = registration_of(header().src);
  if (!write_all(socket(), request)) return os::system_error("register");
  Header answer;
  if (!read_exactly(socket(), std::as_writable_bytes(std::span(&answer, 1))))
    return os::system_error("register");
  if (answer.type != type::kOk) return Error(Errc::kAddressInUse, header().src.to_string());
  return {};
}

bool TcpLink::write(std::span<const std::byte> first, std::span<const std::byte> second) {
  return write_both(socket(), first, second);
}

}  // namespace tims::bench
