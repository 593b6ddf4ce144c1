#include "router/core/registrations.h"

#include <map>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace tims::core {
namespace registrations_test {

using std::chrono::milliseconds;

constexpr Address kLadar(0x01140000);
constexpr Address kCamera(0x01150000);
constexpr Origin kHere{Address(0x01000100), 7, 0};

TEST(ExportedTable, TheHashIsThatOfWhatIsThereHoweverItCameAbout) {
  ExportedTable a;
  ExportedTable b;
  a.added(kLadar, kHere);
  a.added(kCamera, kHere);
  b.added(kCamera, kHere);
  b.added(Address(1), kHere);
  b.added(kLadar, kHere);
  EXPECT_NE(a.hash(), b.hash());
  b.removed(Address(1), kHere);
  EXPECT_EQ(a.hash(), b.hash());
  EXPECT_EQ(b.size(), 2U);
  EXPECT_NE(a.number(), b.number()) << "changes are counted, not mailboxes";
}

TEST(ExportedTable, EveryPartOfAnOriginMatters) {
  const std::uint32_t hash = table_hash(kLadar, kHere);
  EXPECT_NE(hash, table_hash(kCamera, kHere));
  EXPECT_NE(hash, table_hash(kLadar, {Address(0x01000200), 7, 0}));
  EXPECT_NE(hash, table_hash(kLadar, {kHere.router, 8, 0}));
  EXPECT_NE(hash, table_hash(kLadar, {kHere.router, 7, 1}));
}

TEST(ExportedTable, ChangesAreRememberedUpToTheLimit) {
  ExportedTable below;
  for (std::uint32_t i = 0; i < ExportedTable::kRemembered; ++i) below.added(Address(i), kHere);
  EXPECT_TRUE(below.remembers(0));
  EXPECT_EQ(below.changed(1), Address(0));
  below.added(kLadar, kHere);
  EXPECT_FALSE(below.remembers(0));
  EXPECT_TRUE(below.remembers(1));
  EXPECT_EQ(below.changed(below.number()), kLadar);
}

constexpr Time kStart = Time(std::chrono::seconds(100));

std::vector<std::uint32_t> seen(const MissingRouters& routers, Time now) {
  std::vector<std::uint32_t> all;
  routers.for_each(now, [&](const MissingRouter& m) { all.push_back(m.router.raw()); });
  return all;
}

TEST(MissingRouters, OneThatIsFoundIsNotMissing) {
  MissingRouters routers;
  for (const std::uint32_t raw : {1U, 2U, 3U})
    routers.add({.router = Address(raw), .since = kStart});
  routers.found(Address(2));
  routers.found(Address(7));
  EXPECT_EQ(seen(routers, kStart), (std::vector<std::uint32_t>{1, 3}));
}

TEST(MissingRouters, TheyAreKeptForATime) {
  MissingRouters routers;
  routers.add({.router = Address(1), .since = kStart});
  const Time end = kStart + kMissingRouterKept;
  EXPECT_EQ(seen(routers, end - milliseconds(1)).size(), 1U);
  EXPECT_EQ(seen(routers, end).size(), 0U);
  routers.add({.router = Address(2), .since = end});
  EXPECT_EQ(seen(routers, kStart).size(), 1U) << "the one that is over is not held either";
}

TEST(MissingRouters, OfTooManyTheOldestGo) {
  MissingRouters routers;
  for (std::uint32_t raw = 1; raw <= kMissingRoutersMax; ++raw)
    routers.add({.router = Address(raw), .since = kStart});
  EXPECT_EQ(seen(routers, kStart).size(), kMissingRoutersMax);
  EXPECT_EQ(seen(routers, kStart).front(), 1U);
  routers.add({.router = Address(5000), .since = kStart});
  EXPECT_EQ(seen(routers, kStart).size(), kMissingRoutersMax);
  EXPECT_EQ(seen(routers, kStart).front(), 2U);
  EXPECT_EQ(seen(routers, kStart).back(), 5000U);
}

class RegistrationsTest : public testing::Test {
 protected:
  // Each client's list and the table are consistent.
  void expect_consistent(const std::vector<Client>& clients) {
    std::size_t total = 0;
    for (const Client& client : clients) {
      for (std::uint32_t i = 0; i < client.mailboxes.size(); ++i) {
        const Table::Entry* entry = registrations_.find(client.mailboxes[i].address);
        ASSERT_NE(entry, nullptr);
        ASSERT_EQ(entry->owner, client.id);
        ASSERT_EQ(entry->position, i);
      }
      total += client.mailboxes.size();
    }
    ASSERT_EQ(registrations_.table().size(), total);
  }

  Registrations registrations_{{5, 6}, text_sink()};
};

TEST_F(RegistrationsTest, RememberWhenAMailboxCame) {
  Client client{.id = {1}};
  registrations_.add(Time(std::chrono::milliseconds(70'900)), client, Address(3), 4);
  EXPECT_EQ(client.mailboxes[0].registered_s, 70U);
  EXPECT_EQ(registrations_.find(Address(3))->handle, 4U);
}

TEST_F(RegistrationsTest, OfALinkTheyRememberTheRouterTheyLiveAt) {
  Client client{.id = {1}};
  Client link{.id = {2}, .info = {.port = PortKind::kLink, .link = {.kind = LinkKind::kSub}}};
  const Origin far{.router = Address(0x01000100), .epoch = 5, .hops = 2};
  registrations_.add(Time{}, client, Address(3), 4);
  registrations_.add(Time{}, link, Address(6), far);
  EXPECT_EQ(registrations_.origin(client, *registrations_.find(Address(3))), registrations_.here());
  EXPECT_EQ(registrations_.origin(link, *registrations_.find(Address(6))), far);
  EXPECT_EQ(registrations_.exported_table().size(), 2U);
  registrations_.remove(link, Address(6));
  registrations_.remove_last(client);
  EXPECT_EQ(registrations_.exported_table().size(), 0U);
  EXPECT_EQ(registrations_.exported_table().hash(), 0U) << "what was added is what was removed";
}

TEST_F(RegistrationsTest, TableAndListsStayInStep) {
  std::mt19937 generator(3);
  const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
  std::vector<Client> clients(5);
  for (std::uint32_t i = 0; i < clients.size(); ++i) clients[i].id = {i + 1};
  for (int step = 0; step < 20'000; ++step) {
    const Address address(random() % 200);
    if (const Table::Entry* entry = registrations_.find(address)) {
      registrations_.remove(clients[entry->owner.value - 1], address);
      EXPECT_EQ(registrations_.find(address), nullptr);
    } else {
      registrations_.add(Time{}, clients[random() % clients.size()], address, random());
    }
    if (step % 1000 == 0) {
      Client& client = clients[random() % clients.size()];
      while (!client.mailboxes.empty()) {
        EXPECT_EQ(registrations_.find(registrations_.remove_last(client)), nullptr);
      }
    }
    if (step % 100 == 0) expect_consistent(clients);
  }
}

TEST(Clients, NumbersRunOnAndAreNotUsedAgain) {
  Clients clients;
  const ClientId first = clients.add({}, Time{}).id;
  EXPECT_EQ(first.value, 1U);
  clients.remove(first);
  const ClientId second = clients.add({}, Time{}).id;
  EXPECT_EQ(second.value, 2U);
  EXPECT_EQ(clients.find(first), nullptr);
  EXPECT_EQ(clients.size(), 1U);
}

TEST(Clients, NobodyHasNumber0) {
  const Clients clients;
  EXPECT_EQ(clients.find(kNoClient), nullptr);
  EXPECT_EQ(clients.find({12345}), nullptr);
}

TEST(Clients, SlotsAreReusedWhileOldClientsStay) {
  Clients clients;
  const ClientId oldest = clients.add({.token = 77}, Time{}).id;
  for (int i = 0; i < 10'000; ++i) clients.remove(clients.add({}, Time{}).id);
  ASSERT_NE(clients.find(oldest), nullptr);
  EXPECT_EQ(clients.find(oldest)->info.token, 77U);
  EXPECT_EQ(clients.size(), 1U);
}

TEST(Clients, ManyAtOnceAreAllFound) {
  Clients clients;
  std::vector<ClientId> ids;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const Client& client = clients.add({.token = i}, Time{});
    if (i % 3 == 0) {
      clients.remove(client.id);
    } else {
      ids.push_back(client.id);
    }
  }
  std::set<std::uint32_t> tokens;
  for (const ClientId id : ids) {
    ASSERT_NE(clients.find(id), nullptr);
    tokens.insert(clients.find(id)->info.token);
  }
  EXPECT_EQ(tokens.size(), ids.size());
  std::size_t visited = 0;
  clients.for_each([&](const Client&) { ++visited; });
  EXPECT_EQ(visited, ids.size());
}

}  // namespace registrations_test

}  // namespace tims::core
