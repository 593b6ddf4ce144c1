#include "router/core/clients.h"

#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace tims::core {
namespace {

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

}  // namespace
}  // namespace tims::core
