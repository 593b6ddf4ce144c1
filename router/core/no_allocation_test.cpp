// Forwarding a message does not allocate. A program of its own, because it counts every `new`.
#include <gtest/gtest.h>

#include "router/core/router.h"
#include "tests/support/counted_new.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::core {
namespace no_allocation_test {

class CountingSink final : public Port, public RouterHooks {
 public:
  Outcome deliver(Time, const Receiver&, const Message&) override {
    ++delivered;
    return outcome;
  }
  void reply(Time, const Receiver&, const Header&) override { ++replies; }
  void close(const Receiver&, CloseReason) override {}
  void admin(Time, ClientId, const Message&) override {}
  void traced(ClientId, ClientId, const Message&) override {}
  void event(const Event&) override {}

  Outcome outcome = Outcome::kDelivered;
  int delivered = 0;
  int replies = 0;
};

TEST(NoAllocation, ForwardingAMessage) {
  CountingSink sink;
  Router router({.address = Address(0x100)}, {1, 2}, sink);
  for (const auto kind : values<PortKind, kPortKindCount>()) router.attach(kind, sink);
  const Time now{std::chrono::seconds(5)};
  const ClientId tcp = router.connect(now, {.port = PortKind::kTcp, .lifesign = true});
  const ClientId local = router.connect(now, {.port = PortKind::kLocal});
  router.register_mailbox(now, tcp, Address(1));
  router.register_mailbox(now, local, Address(2));

  std::array<std::byte, kHeaderSize> bytes{};
  const auto send = [&](ClientId from, const Header& header) {
    Message message{header, bytes};
    return router.on_message(now, from, message);
  };
  const std::size_t before = test::allocations();
  ASSERT_GT(before, 0U) << "it counts";
  for (const Outcome outcome :
       {Outcome::kDelivered, Outcome::kMailboxReplaced, Outcome::kQueueFull}) {
    sink.outcome = outcome;
    send(tcp, {.type = 1, .dest = Address(2), .src = Address(1)});
    send(tcp, {.type = 1, .dest = Address(2), .src = Address(77)});
    send(local, {.type = 1, .dest = Address(1), .src = Address(2)});
  }
  send(tcp, {.type = 1, .dest = Address(99), .src = Address(1)});
  send(local, {.type = 1, .dest = Address(1), .src = Address(99)});
  send(tcp, {.type = type::kOk});
  send(tcp, {.type = wire::router_command::kMailboxInit});
  router.on_timeout(router.next_timeout());
  router.on_lost(now, PortKind::kTcp, tcp, Outcome::kQueueReplaced, 3, 100);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(sink.delivered, 9);
  EXPECT_EQ(sink.replies, 2);
}

TEST(NoAllocation, KeepingTheNewestValues) {
  CountingSink sink;
  Router router({.address = Address(0x100)}, {1, 2}, sink);
  for (const auto kind : values<PortKind, kPortKindCount>()) router.attach(kind, sink);
  NewestValues newest(8 << 10, {1, 2});
  NewestRule rule{.status = true, .length_max = 4096};
  rule.classes.set();
  newest.set_rule(rule);
  router.keep_newest(newest);
  const Time now{std::chrono::seconds(5)};
  const ClientId robot = router.connect(now, {.port = PortKind::kLocal});
  for (std::uint32_t i = 0; i < 20; ++i) router.register_mailbox(now, robot, Address(i));
  std::array<std::byte, 2000> bytes{};
  const std::size_t before = test::allocations();
  for (std::uint32_t i = 0; i < 200; ++i) {
    const std::size_t size = kHeaderSize + i * 7 % 1900;
    Message message{{.flags = flag::kStream,
                     .type = i % 3 == 0 ? type::kEnabled : type::kData,
                     .dest = Address(99),
                     .src = Address(i % 2 == 0 ? 0 : i % 20),
                     .length = static_cast<std::uint32_t>(size)},
                    std::span(bytes).first(size)};
    router.on_message(now, robot, message);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_LE(newest.counts().values, 8U);
  EXPECT_GT(newest.counts().replaced, 0U);
  EXPECT_GT(newest.counts().evicted, 0U);
}

}  // namespace no_allocation_test
}  // namespace tims::core
