#include "rack/codec/schema.h"

#include <limits>

#include <gtest/gtest.h>

#include "proxies/codec/sample_fixture.h"

namespace rack {
namespace schema_test {

using test::Sample;

TEST(Schema, ReadsAndWritesWhatTheCodecDoes) {
  const Sample s{.pos = {.x = 1},
                 .name = "abc",
                 .imageSize = 1,
                 .points = {{.x = 2}},
                 .image = {std::byte{5}}};
  const auto body = test::body_of(s);
  for (const std::endian to : {std::endian::little, std::endian::big}) {
    const auto there = recode(kSchema<Sample>, body, std::endian::native, to);
    ASSERT_TRUE(there);
    std::vector<std::byte> expected(encoded_size(s));
    ASSERT_TRUE(encode(s, expected, to));
    EXPECT_EQ(*there, expected);
  }
}

TEST(Schema, RefusesWithTheSameReasonAsTheCodec) {
  std::vector<std::byte> body = test::body_of({.points = {{.x = 2}}});
  const auto agree = [&] {
    const auto read = read_value(kSchema<Sample>, body, std::endian::native);
    const auto decoded = decode<Sample>(body);
    EXPECT_FALSE(read);
    EXPECT_FALSE(decoded);
    if (read || decoded) return;
    EXPECT_EQ(read.error().message(), decoded.error().message());
  };
  body.pop_back();
  agree();  // an element is missing
  body.resize(body.size() + 3);
  agree();  // two bytes too many
  body.resize(10);
  agree();
  body = test::body_of({});
  body[wire_size<Sample>() - 1] = std::byte{0x7F};  // of the count
  agree();
}

TEST(Schema, WritesNoTailOfAnotherLength) {
  MessageValue made = made_value(kSchema<Sample>);
  ASSERT_TRUE(assign(kSchema<Sample>, made, {"imageSize", "3"}));
  const auto body = write_value(kSchema<Sample>, made, std::endian::native);
  ASSERT_FALSE(body);
  EXPECT_EQ(body.error().detail(),
            "Sample.image has 0 elements, but the other fields give 3: correct one of them");
}

}  // namespace schema_test
}  // namespace rack
