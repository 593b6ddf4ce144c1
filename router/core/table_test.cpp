#include "router/core/table.h"

#include <random>
#include <set>
#include <unordered_map>
#include <vector>

#include <gtest/gtest.h>

namespace tims::core {
namespace table_test {

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

// With the owner's entry (OwnedMailbox in registrations.h: 8 bytes, at most twice that in a vector
// that has grown) a mailbox needs less than 64 bytes.
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

std::vector<std::uint32_t> all_from(const AddressSet& set, std::uint32_t first,
                                    std::size_t limit = SIZE_MAX) {
  std::vector<std::uint32_t> found;
  set.for_each_from(Address(first), [&](Address address) {
    found.push_back(address.raw());
    return found.size() < limit;
  });
  return found;
}

TEST(AddressSet, IsEmpty) {
  const AddressSet set;
  EXPECT_TRUE(all_from(set, 0).empty());
}

TEST(AddressSet, ListsInOrderFromAnyAddressOn) {
  AddressSet set;
  for (const std::uint32_t address : {7U, 0xFFFFFFFFU, 0U, 0x03140000U})
    set.insert(Address(address));
  EXPECT_EQ(all_from(set, 0), (std::vector{0U, 7U, 0x03140000U, 0xFFFFFFFFU}));
  EXPECT_EQ(all_from(set, 7), (std::vector{7U, 0x03140000U, 0xFFFFFFFFU}));
  EXPECT_EQ(all_from(set, 8), (std::vector{0x03140000U, 0xFFFFFFFFU}));
  EXPECT_EQ(all_from(set, 1, 2), (std::vector{7U, 0x03140000U}));
  set.erase(Address(0));
  set.erase(Address(0xFFFFFFFFU));
  EXPECT_EQ(all_from(set, 0), (std::vector{7U, 0x03140000U}));
}

// As std::set, whatever comes and goes; and what is gone takes no memory.
TEST(AddressSet, AgreesWithAModel) {
  std::mt19937 random(3);
  AddressSet set;
  std::set<std::uint32_t> model;
  const std::size_t empty_bytes = set.memory_bytes();
  const auto agree = [&] {
    const auto first = static_cast<std::uint32_t>(random());
    const std::vector<std::uint32_t> wanted(model.lower_bound(first), model.end());
    EXPECT_EQ(all_from(set, first), wanted);
  };
  for (int round = 0; round < 6; ++round) {
    for (int i = 0; i < 20'000; ++i) {
      // Many close together in the odd rounds.
      const auto address = static_cast<std::uint32_t>(round % 2 == 0 ? random() : random() % 9'000);
      const bool more = round < 4 ? random() % 3 != 0 : random() % 3 == 0;
      if (more && model.insert(address).second) set.insert(Address(address));
      if (!more && model.erase(address) == 1) set.erase(Address(address));
    }
    agree();
  }
  while (!model.empty()) {
    const auto victim = random() % 2 == 0 ? model.begin() : std::prev(model.end());
    set.erase(Address(*victim));
    model.erase(victim);
    if (model.size() % 1'000 == 0) agree();
  }
  EXPECT_EQ(set.memory_bytes(), empty_bytes);
}

TEST(AddressSet, AMillionCostAtMost16BytesEach) {
  constexpr std::uint32_t kCount = 1'000'000;
  AddressSet ascending;
  AddressSet scattered;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    ascending.insert(Address(i));
    scattered.insert(Address(i * 0x9E3779B1U));
  }
  EXPECT_LE(ascending.memory_bytes(), std::size_t{5} * kCount);
  EXPECT_LE(scattered.memory_bytes(), std::size_t{16} * kCount);
  EXPECT_EQ(all_from(ascending, 999'999).size(), 1U);
}

}  // namespace table_test
}  // namespace tims::core
