#include "tests/bench/tcp_link.h"

#include "tests/bench/addresses.h"

namespace tims::bench {

namespace {

constexpr std::size_t kGather = 64 << 10;
constexpr std::uint32_t kLargest = 64U << 20;
constexpr Duration kTcpLinkPatience = std::chrono::seconds(5);

}  // namespace

TcpLink::TcpLink(const Plan& plan, Between between, client::TcpClient client)
    : client_(std::move(client)),
      between_(between),
      header_(message_header(plan)),
      gather_(plan.streaming() ? kGather : 0) {}

// Like the original C library: disables the watchdog, registers the mailbox, reads one answer.
Result<TcpLink> TcpLink::open(const Plan& plan, Between between) {
  const auto router = wire::parse_endpoint(plan.endpoint);
  if (!router) return router.error();
  const Time deadline = os::deadline_after(kTcpLinkPatience);
  auto client =
      client::TcpClient::connect(std::get<wire::TcpEndpoint>(*router), deadline, kLargest);
  if (!client) return client.error();
  client->protocol().put_command(wire::router_command::kDisableWatchdog);
  if (auto done = client->register_mailbox(message_header(plan).src, deadline); !done)
    return done.error();
  make_blocking(client->socket());
  return TcpLink(plan, between, std::move(*client));
}

}  // namespace tims::bench
