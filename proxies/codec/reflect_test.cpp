#include "rack/codec/reflect.h"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rack/codec/fields.h"
#include "rack/codec/quantity.h"

namespace rack {
namespace reflect_test {

struct Inner {
  i32 a = 0;
  f64 b = 0;
};

struct Sample {
  u32 recordingTime = 0;
  Inner inner;
  Millimetres<i32> vx;
  std::array<f32, 9> rotation{};
  Text<40> logPathName;
  Count pointNum;
  Sequence<Inner, 7> points;
  i32 last_1 = 0;

  [[nodiscard]] int hook() const { return 0; }
};

TEST(Reflect, CountsFieldsAndNothingElse) { EXPECT_EQ(reflect::kFieldCount<Sample>, 8U); }

TEST(Reflect, NamesFieldsOfEveryKind) {
  EXPECT_EQ((reflect::kFieldName<Sample, 0>), "recordingTime");
  EXPECT_EQ((reflect::kFieldName<Sample, 1>), "inner");
  EXPECT_EQ((reflect::kFieldName<Sample, 2>), "vx");
  EXPECT_EQ((reflect::kFieldName<Sample, 3>), "rotation");
  EXPECT_EQ((reflect::kFieldName<Sample, 4>), "logPathName");
  EXPECT_EQ((reflect::kFieldName<Sample, 5>), "pointNum");
  EXPECT_EQ((reflect::kFieldName<Sample, 6>), "points");
  EXPECT_EQ((reflect::kFieldName<Sample, 7>), "last_1");
}

TEST(Reflect, NamesTypes) {
  EXPECT_EQ(reflect::kTypeName<Sample>, "Sample");
  EXPECT_EQ(reflect::kTypeName<Inner>, "Inner");
}

TEST(Reflect, VisitsInOrderUntilFalse) {
  const Sample sample;
  std::vector<std::size_t> seen;
  EXPECT_FALSE(reflect::all_fields(sample, [&](const auto&, auto index) {
    seen.push_back(index);
    return index < 2;
  }));
  EXPECT_EQ(seen, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_TRUE(reflect::all_fields(sample, [](const auto&, auto) { return true; }));
}

TEST(Reflect, VisitsTheFieldsThemselves) {
  Inner inner;
  reflect::all_fields(inner, [](auto& field, auto) {
    field = 3;
    return true;
  });
  EXPECT_EQ(inner.a, 3);
  EXPECT_EQ(inner.b, 3.0);
}

}  // namespace reflect_test
}  // namespace rack
