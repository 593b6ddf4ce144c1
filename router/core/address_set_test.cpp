#include "router/core/address_set.h"

#include <random>
#include <set>

#include <gtest/gtest.h>

namespace tims::core {
namespace {

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

TEST(AddressSet, TellsInOrderFromAnyAddressOn) {
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

}  // namespace
}  // namespace tims::core
