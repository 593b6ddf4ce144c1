#include "router/core/missing_routers.h"

#include <vector>

#include <gtest/gtest.h>

namespace tims::core {
namespace {

using std::chrono::milliseconds;
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

}  // namespace
}  // namespace tims::core
