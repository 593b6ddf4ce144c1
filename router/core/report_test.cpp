#include "router/core/report.h"

#include "router/core/router_fixture.h"

namespace tims::core::test {
namespace report_test {

class ReportTest : public RouterTest {
 protected:
  MailboxPage page(std::string_view match, std::optional<Address> after, std::size_t limit) {
    return report_mailboxes(router_, at(160), *AddressPattern::parse(match), after, limit);
  }
};

TEST_F(ReportTest, MailboxesComeInPagesByAddress) {
  const ClientId a = connect(PortKind::kLocal, "laser");
  const ClientId b = connect();
  for (const std::uint32_t address : {7U, 3U, 0xFFFFFFFFU, 0U, 5U}) {
    router_.register_mailbox(now_, address % 2 == 0 ? a : b, Address(address), address);
  }
  MailboxPage first = page("*", std::nullopt, 3);
  ASSERT_EQ(first.items.size(), 3U);
  EXPECT_EQ(first.items[0].address, Address(0));
  EXPECT_EQ(first.items[0].owner.name.view(), "laser");
  EXPECT_EQ(first.items[0].age, std::chrono::seconds(60));
  EXPECT_EQ(first.items[2].address, Address(5));
  EXPECT_TRUE(first.more);
  const MailboxPage second = page("*", first.items.back().address, 3);
  ASSERT_EQ(second.items.size(), 2U);
  EXPECT_EQ(second.items[1].address, Address(0xFFFFFFFF));
  EXPECT_FALSE(second.more);
}

TEST_F(ReportTest, MailboxesAreFoundByPattern) {
  const ClientId a = connect();
  for (const std::uint32_t raw : {0x03140000U, 0x03140001U, 0x03180000U}) {
    router_.register_mailbox(now_, a, Address(raw));
  }
  EXPECT_EQ(page("Ladar(*/*)", std::nullopt, 10).items.size(), 2U);
  EXPECT_EQ(page("Pilot(4/0)", std::nullopt, 10).items.size(), 0U);
}

// However many there are: a question costs what its page costs.
TEST_F(ReportTest, APageLooksAtABoundedNumberOfMailboxes) {
  constexpr std::uint32_t kBase = 0x03000000;
  const ClientId link = connect(PortKind::kLink, "base");
  const auto add = [&](std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t i = from; i < to; ++i)
      router_.learn(now_, link, Address(kBase + i),
                    {.router = Address(0x07000500), .epoch = 1, .hops = 1});
  };
  add(0, kLookedAtMax);
  const Address last(kBase + kLookedAtMax - 1);
  EXPECT_FALSE(page("*", std::nullopt, kLookedAtMax).more);
  EXPECT_FALSE(page("Pilot(4/0)", std::nullopt, 1).more);
  add(kLookedAtMax, kLookedAtMax + 2000);
  const MailboxPage nobody = page("Pilot(4/0)", std::nullopt, 1);
  EXPECT_TRUE(nobody.items.empty());
  EXPECT_TRUE(nobody.more);
  EXPECT_EQ(nobody.last, last);
  EXPECT_FALSE(page("Pilot(4/0)", nobody.last, 1).more);
  EXPECT_EQ(page("*", last, 5000).items.size(), 2000U);
}

TEST_F(ReportTest, ARouteSaysWhatWouldHappen) {
  using Verdict = RouteReport::Verdict;
  const ClientId a = connect();
  router_.register_mailbox(now_, a, Address(5));
  EXPECT_EQ(report_route(router_, now_, kOwn, 1).verdict, Verdict::kSelf);
  EXPECT_EQ(report_route(router_, now_, Address(5), 1).mailbox->owner.id, a);
  EXPECT_TRUE(report_route(router_, now_, Address(6), 1).not_available);
  EXPECT_FALSE(report_route(router_, now_, Address(6), -1).not_available);
}

TEST_F(ReportTest, StatusAddsUp) {
  const ClientId a = connect();
  router_.register_mailbox(now_, a, Address(5));
  send(a, {.type = 1, .dest = Address(5), .src = Address(5)});
  send(a, {.type = 1, .dest = Address(6), .src = Address(5)});
  send(a, {.type = command::kLogin});
  const StatusReport status = report_status(router_, now_);
  EXPECT_EQ(status.address, kOwn);
  EXPECT_EQ(status.clients, 1U);
  EXPECT_EQ(status.mailboxes, 1U);
  EXPECT_EQ(status.forwarded, (Count{1, 16}));
  EXPECT_EQ(status.drops, 1U);
  EXPECT_EQ(status.drops_last_minute, 1U);
  const auto counts = report_counts(router_);
  ASSERT_EQ(counts.size(), 3U);
  EXPECT_EQ(counts[0].outcome, Outcome::kDelivered);
  EXPECT_EQ(report_event_counts(router_).size(), kEventKinds.size());
}

TEST_F(ReportTest, ClientsComeInOrderOfTheirNumbers) {
  std::vector<ClientId> ids;
  for (int i = 0; i < 80; ++i) ids.push_back(connect(PortKind::kLocal));
  router_.disconnect(now_, ids[3], CloseReason::kPeerClosed);
  const ClientPage all = report_clients(router_, at(107), {}, 79);
  const auto& clients = all.items;
  ASSERT_EQ(clients.size(), 79U);
  EXPECT_FALSE(all.more);
  EXPECT_TRUE(std::ranges::is_sorted(clients, {}, [](const auto& c) { return c.client.id; }));
  EXPECT_EQ(clients[0].connected, std::chrono::seconds(7));
  const ClientPage page = report_clients(router_, at(107), ids[2], 5);
  ASSERT_EQ(page.items.size(), 5U);
  EXPECT_TRUE(page.more);
  EXPECT_EQ(page.items[0].client.id, ids[4]) << "the one between has gone";
  EXPECT_TRUE(report_clients(router_, at(107), ids[79], 5).items.empty());
}

TEST_F(ReportTest, EventsAfterANumberWithTheCountOfLostOnes) {
  for (int i = 0; i < 5; ++i) router_.disconnect(now_, connect(), CloseReason::kPeerClosed);
  EventPage page = report_events(router_.events(), 7, 100);
  ASSERT_EQ(page.items.size(), 3U);
  EXPECT_EQ(page.items[0].sequence, 8U);
  EXPECT_EQ(page.last, 10U);
  EXPECT_EQ(page.lost, 0U);
  EXPECT_EQ(report_events(router_.events(), 0, 4).items.size(), 4U);
  EXPECT_TRUE(report_events(router_.events(), 10, 4).items.empty());
  // A number from before a restart.
  EXPECT_EQ(report_events(router_.events(), 999, 100).items.size(), 10U);

  for (int i = 0; i < 3000; ++i) router_.disconnect(now_, connect(), CloseReason::kPeerClosed);
  page = report_events(router_.events(), 10, 10'000);
  EXPECT_EQ(page.items.size(), EventLog::kCapacity);
  EXPECT_EQ(page.lost, 6000 - EventLog::kCapacity);
  EXPECT_EQ(page.items.back().sequence, page.last);
}

}  // namespace report_test
}  // namespace tims::core::test
