#include "base/slot_map.h"

#include <gtest/gtest.h>

namespace tims::base {
namespace slot_map_test {

TEST(SlotMap, GivesTheNumberThatWasLeftLast) {
  SlotMap<int> map;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(map.next(), static_cast<std::uint32_t>(i));
    EXPECT_EQ(map.add(std::make_unique<int>(i)), i);
  }
  map.erase(0);
  map.erase(2);
  EXPECT_EQ(map.find(2), nullptr);
  EXPECT_EQ(map.next(), 2U);
  map.add(std::make_unique<int>(7));
  EXPECT_EQ(*map.find(2), 7);
  EXPECT_EQ(map.next(), 0U);
}

TEST(SlotMap, ShowsWhatIsThere) {
  SlotMap<int> map;
  EXPECT_EQ(map.find(0), nullptr) << "nothing has ever been there";
  for (int i = 1; i <= 3; ++i) map.add(std::make_unique<int>(i));
  map.erase(1);
  int sum = 0;
  map.for_each([&](int& thing) { sum += thing; });
  EXPECT_EQ(sum, 4);
}

}  // namespace slot_map_test
}  // namespace tims::base
