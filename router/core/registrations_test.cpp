#include "router/core/registrations.h"

#include <map>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tims::core {
namespace {

class RegistrationsTest : public testing::Test {
 protected:
  // Each client's list and the table say the same.
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

  Registrations registrations_{{5, 6}};
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
  EXPECT_EQ(registrations_.below().size(), 2U);
  registrations_.remove(link, Address(6));
  registrations_.remove_last(client);
  EXPECT_EQ(registrations_.below().size(), 0U);
  EXPECT_EQ(registrations_.below().hash(), 0U) << "what was added is what was removed";
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

}  // namespace
}  // namespace tims::core
