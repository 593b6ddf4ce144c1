#include "router/core/below.h"

#include <gtest/gtest.h>

namespace tims::core {
namespace {

constexpr Address kLadar(0x01140000);
constexpr Address kCamera(0x01150000);
constexpr Origin kHere{Address(0x01000100), 7, 0};

TEST(Below, TheHashIsThatOfWhatIsThereHoweverItCameAbout) {
  Below a;
  Below b;
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

TEST(Below, EveryPartOfAnOriginMatters) {
  const std::uint32_t hash = table_hash(kLadar, kHere);
  EXPECT_NE(hash, table_hash(kCamera, kHere));
  EXPECT_NE(hash, table_hash(kLadar, {Address(0x01000200), 7, 0}));
  EXPECT_NE(hash, table_hash(kLadar, {kHere.router, 8, 0}));
  EXPECT_NE(hash, table_hash(kLadar, {kHere.router, 7, 1}));
}

TEST(Below, ChangesAreRememberedUpToTheLimit) {
  Below below;
  for (std::uint32_t i = 0; i < Below::kRemembered; ++i) below.added(Address(i), kHere);
  EXPECT_TRUE(below.remembers(0));
  EXPECT_EQ(below.changed(1), Address(0));
  below.added(kLadar, kHere);
  EXPECT_FALSE(below.remembers(0));
  EXPECT_TRUE(below.remembers(1));
  EXPECT_EQ(below.changed(below.number()), kLadar);
}

}  // namespace
}  // namespace tims::core
