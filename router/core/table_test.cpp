#include "router/core/table.h"

#include <random>
#include <unordered_map>
#include <vector>

#include <gtest/gtest.h>

namespace tims::core {
namespace {

constexpr HashSeed kSeed{0x0123456789abcdef, 0xfedcba9876543210};

Table::Entry entry(std::uint32_t address, std::uint32_t owner = 1, std::uint32_t handle = 0) {
  return {.address = Address(address), .owner = {owner}, .handle = handle};
}

TEST(Table, FindsWhatWasInserted) {
  Table table(kSeed);
  EXPECT_EQ(table.find(Address(7)), nullptr);
  table.insert(entry(7, 3, 9));
  const Table::Entry* found = table.find(Address(7));
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->owner, ClientId{3});
  EXPECT_EQ(found->handle, 9U);
  EXPECT_EQ(table.find(Address(8)), nullptr);
  EXPECT_EQ(table.size(), 1U);
}

TEST(Table, EveryAddressIsLegal) {
  Table table(kSeed);
  for (const std::uint32_t address : {0U, 1U, 0x80000000U, 0xFFFFFFFFU}) {
    EXPECT_EQ(table.find(Address(address)), nullptr);
    table.insert(entry(address));
    EXPECT_NE(table.find(Address(address)), nullptr);
  }
  table.erase(table.find(Address(0)));
  EXPECT_EQ(table.find(Address(0)), nullptr);
  EXPECT_NE(table.find(Address(0xFFFFFFFF)), nullptr);
}

TEST(Table, VisitsEveryEntryOnce) {
  Table table(kSeed);
  for (std::uint32_t i = 0; i < 1000; ++i) table.insert(entry(i));
  std::vector<int> seen(1000);
  table.for_each([&](const Table::Entry& e) { ++seen[e.address.raw()]; });
  EXPECT_EQ(seen, std::vector<int>(1000, 1));
}

// With the list of the owner (clients.h: at most twice 8 bytes) this stays below 64 bytes.
TEST(Table, NeedsAtMost43BytesAMailboxOnceItHasGrown) {
  Table table(kSeed);
  for (std::uint32_t i = 0; i < 100'000; ++i) {
    table.insert(entry(i * 0x100));
    if (table.size() >= 48) {
      ASSERT_LE(table.memory_bytes(), table.size() * 43) << table.size();
    }
  }
}

// A small universe of keys, so that they meet and are removed from the middle of runs.
TEST(Table, BehavesAsAModelDoes) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    std::mt19937 generator(seed);
    const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
    Table table({seed, ~std::uint64_t{seed}});
    std::unordered_map<std::uint32_t, std::uint32_t> model;  // address -> handle
    const std::uint32_t universe = 50 << (seed % 5);
    for (std::uint32_t step = 0; step < 20'000; ++step) {
      const std::uint32_t address = random() % universe * 0x01000000;
      const Table::Entry* found = table.find(Address(address));
      const auto expected = model.find(address);
      ASSERT_EQ(found != nullptr, expected != model.end()) << "seed " << seed << " step " << step;
      if (found == nullptr) {
        table.insert(entry(address, 1 + step, step));
        model[address] = step;
      } else {
        ASSERT_EQ(found->handle, expected->second) << "seed " << seed << " step " << step;
        table.erase(found);
        model.erase(expected);
      }
      ASSERT_EQ(table.size(), model.size());
    }
    for (const auto& [address, handle] : model) {
      ASSERT_NE(table.find(Address(address)), nullptr);
      EXPECT_EQ(table.find(Address(address))->handle, handle);
    }
  }
}

}  // namespace
}  // namespace tims::core
