#include "rack/codec/codec.h"

#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rack/codec/quantity.h"
#include "tims/address.h"

namespace rack {
namespace codec_test {

using tims::Errc;

struct Point {
  i32 x = 0;
  i16 y = 0;
  i16 z = 0;
};

struct Scan {
  TimeStamp recordingTime = 0;
  i64 utc = 0;  // not aligned on the wire
  Text<4> tag = {};
  tims::Address address = {};
  Count pointNum = {};
  i16 between = 0;
  Sequence<Point, 3> points = {};
};

struct Image {
  u16 width = 0;
  u16 height = 0;
  i32 extra = 0;
  Tail<std::byte, 6> pixels = {};
  Tail<Point, 2> marks = {};

  [[nodiscard]] std::array<std::int64_t, 2> tail_sizes() const {
    return {std::int64_t{width} * height, extra};
  }
};

struct Whole {
  Count num = {};
  Sequence<i16, 4> values = {};
  static constexpr std::size_t kWholeSize = 12;
};

struct Padded {
  Count num = {};
  Sequence<u8, 4> values = {};
  static constexpr std::size_t kWholeSize = 8;
  static constexpr bool kPads = true;
};

struct Surplus {
  i32 value = 0;
  static constexpr std::size_t kSurplus = 3;
};

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

template <typename T>
std::vector<std::byte> encoded(const T& value, std::endian order) {
  std::vector<std::byte> bytes(encoded_size(value));
  const auto size = encode(value, bytes, order);
  EXPECT_TRUE(size) << size.error().message();
  EXPECT_EQ(size ? *size : 0, bytes.size());
  return bytes;
}

template <typename T>
std::string refused(std::span<const std::byte> bytes) {
  const auto result = decode<T>(bytes, std::endian::little);
  if (result) return "accepted";
  EXPECT_EQ(result.error().code(), Errc::kMalformed);
  const std::string& text = result.error().detail();
  return text.substr(0, text.find(';'));
}

Scan scan() {
  return {.recordingTime = 0x01020304,
          .utc = 0x0506070809,
          .tag = "abc",
          .address = tims::Address(0x00110203),
          .between = 0x0708,
          .points = {{1, 2, 3}, {-1, -2, -3}}};
}

TEST(Codec, LittleEndianBytes) {
  EXPECT_EQ(
      encoded(scan(), std::endian::little),
      bytes_of({4, 3, 2, 1, 9, 8, 7, 6, 5, 0, 0, 0, 'a', 'b', 'c', 0,   3,   2,   17,  0,   2,
                0, 0, 0, 8, 7, 1, 0, 0, 0, 2, 0, 3, 0,   255, 255, 255, 255, 254, 255, 253, 255}));
}

TEST(Codec, BigEndianBytes) {
  EXPECT_EQ(
      encoded(scan(), std::endian::big),
      bytes_of({1, 2, 3, 4, 0, 0, 0, 5, 6, 7, 8, 9, 'a', 'b', 'c', 0,   0,   17,  2,   3,   0,
                0, 0, 2, 7, 8, 0, 0, 0, 1, 0, 2, 0, 3,   255, 255, 255, 255, 255, 254, 255, 253}));
}

TEST(Codec, ReadsBackBothOrders) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const auto again = decode<Scan>(encoded(scan(), order), order);
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_EQ(again->recordingTime, TimeStamp(0x01020304));
    EXPECT_EQ(again->utc, 0x0506070809);
    EXPECT_EQ(again->tag, "abc");
    EXPECT_EQ(again->address.raw(), 0x00110203U);
    EXPECT_EQ(again->between, 0x0708);
    ASSERT_EQ(again->points.size(), 2U);
    EXPECT_EQ(again->points[1].z, -3);
  }
}

TEST(Codec, ReadsMessagesInTheOrderTheirHeaderStates) {
  const auto body = encoded(scan(), std::endian::big);
  tims::Header header{.flags = 0};
  EXPECT_EQ(decode<Scan>(tims::MessageView{header, body})->utc, scan().utc);
  header.flags = tims::flag::kBodyLittleEndian;
  EXPECT_FALSE(decode<Scan>(tims::MessageView{header, body}));
}

TEST(Codec, SizesAreKnownWithoutAnObject) {
  static_assert(wire_size<Point>() == 8);
  static_assert(wire_size<Scan>() == 26);
  static_assert(body_max<Scan>() == 26 + 3 * 8);
  static_assert(wire_size<Image>() == 8);
  static_assert(body_max<Image>() == 8 + 6 + 2 * 8);
  static_assert(body_max<Surplus>() == 7);
}

TEST(Codec, KnowsWhatMayBeCopiedAsAWhole) {
  static_assert(is_plain<Point>());
  static_assert(is_plain<Millimetres<i32>>());
  static_assert(is_plain<tims::Address>());
  static_assert(!is_plain<Text<4>>());
  static_assert(!is_plain<Scan>());
  struct Gap {
    i32 a;
    i64 b;
  };
  static_assert(!is_plain<Gap>());
}

TEST(Codec, AsManyElementsAsAllowed) {
  Scan full = scan();
  for (const std::size_t count : {2U, 3U}) {
    full.points.resize(count);
    const auto again = decode<Scan>(encoded(full, std::endian::little), std::endian::little);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->points.size(), count);
  }
  full.points.resize(4);
  std::vector<std::byte> bytes(100);
  const auto sent = encode(full, bytes);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code(), Errc::kInvalidArgument);
  EXPECT_EQ(sent.error().detail(), "Scan.points has 4 elements, allowed are 3: send fewer");
}

TEST(Codec, RefusesCountsByName) {
  std::vector<std::byte> bytes = encoded(scan(), std::endian::little);
  bytes[20] = std::byte{4};
  EXPECT_EQ(refused<Scan>(bytes), "Scan.pointNum is 4, allowed are 0 to 3");
  bytes[23] = std::byte{255};
  EXPECT_EQ(refused<Scan>(bytes), "Scan.pointNum is -16777212, allowed are 0 to 3");
  bytes[20] = std::byte{3};
  bytes[23] = std::byte{0};
  EXPECT_EQ(refused<Scan>(bytes), "Scan.pointNum needs 24 bytes, only 16 bytes follow");
}

TEST(Codec, RefusesBodiesThatAreTooShortOrTooLong) {
  std::vector<std::byte> bytes = encoded(scan(), std::endian::little);
  EXPECT_EQ(refused<Scan>(std::span(bytes).first(25)), "Scan has at least 26 bytes, not 25 bytes");
  EXPECT_EQ(refused<Scan>({}), "Scan has at least 26 bytes, not 0 bytes");
  bytes.push_back({});
  EXPECT_EQ(refused<Scan>(bytes), "Scan is 42 bytes long by its own counts, not 43 bytes");
}

TEST(Codec, TailsAreAsLongAsOtherFieldsSay) {
  const Image image{
      .width = 2, .height = 3, .extra = 1, .pixels = Tail<std::byte, 6>(6), .marks = {{1, 2, 3}}};
  const auto bytes = encoded(image, std::endian::big);
  EXPECT_EQ(bytes.size(), 8U + 6 + 8);
  const auto again = decode<Image>(bytes, std::endian::big);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->pixels.size(), 6U);
  EXPECT_EQ(again->marks.at(0).y, 2);
}

TEST(Codec, RefusesTailsThatDoNotFit) {
  EXPECT_EQ(refused<Image>(bytes_of({255, 255, 255, 255, 0, 0, 0, 0})),
            "Image.pixels is 4294836225, allowed are 0 to 6");
  EXPECT_EQ(refused<Image>(bytes_of({1, 0, 1, 0, 255, 255, 255, 255, 7})),
            "Image.marks is -1, allowed are 0 to 2");
  EXPECT_EQ(refused<Image>(bytes_of({2, 0, 1, 0, 0, 0, 0, 0, 7})),
            "Image.pixels needs 2 bytes, only 1 bytes follow");
  const Image image{.width = 2, .height = 3};
  std::vector<std::byte> bytes(100);
  EXPECT_EQ(encode(image, bytes).error().detail(),
            "Image.pixels has 0 elements, but the other fields give 6: correct one of them");
}

TEST(Codec, WholeTablesOfOriginalsAreAccepted) {
  std::vector<std::byte> bytes = encoded(Whole{.values = {7}}, std::endian::little);
  EXPECT_EQ(bytes.size(), 6U);
  bytes.resize(12);
  const auto whole = decode<Whole>(bytes, std::endian::little);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->values.size(), 1U);
  bytes.resize(11);
  EXPECT_FALSE(decode<Whole>(bytes, std::endian::little));
  bytes.resize(13);
  EXPECT_FALSE(decode<Whole>(bytes, std::endian::little));
}

TEST(Codec, PadsWhereOriginalsExpectIt) {
  EXPECT_EQ(encoded(Padded{.values = {7}}, std::endian::little),
            bytes_of({1, 0, 0, 0, 7, 0, 0, 0}));
  EXPECT_TRUE(decode<Padded>(bytes_of({1, 0, 0, 0, 7}), std::endian::little));
}

TEST(Codec, KnownSurplusIsAccepted) {
  EXPECT_TRUE(decode<Surplus>(bytes_of({1, 0, 0, 0}), std::endian::little));
  EXPECT_TRUE(decode<Surplus>(bytes_of({1, 0, 0, 0, 0, 0, 0}), std::endian::little));
  EXPECT_FALSE(decode<Surplus>(bytes_of({1, 0, 0, 0, 0, 0}), std::endian::little));
}

TEST(Codec, BufferTooSmall) {
  std::vector<std::byte> bytes(41);
  const auto sent = encode(scan(), bytes);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code(), Errc::kBufferTooSmall);
  EXPECT_EQ(sent.error().detail(), "Scan needs 42 bytes, the buffer has 41 bytes");
}

TEST(Codec, DecodesInPlaceWithoutAllocating) {
  Scan into;
  into.points.reserve_all();
  const Point* place = into.points.data();
  ASSERT_TRUE(decode(encoded(scan(), std::endian::big), std::endian::big, into));
  EXPECT_EQ(into.points.data(), place);
  EXPECT_EQ(into.points.size(), 2U);
}

TEST(Codec, HostileTextIsCut) {
  std::vector<std::byte> bytes = encoded(scan(), std::endian::little);
  for (std::size_t i = 12; i < 16; ++i) bytes[i] = std::byte{'x'};
  const auto again = decode<Scan>(bytes, std::endian::little);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->tag, "xxx");
}

TEST(Codec, KeepsEveryBitOfAFloat) {
  struct Float {
    f32 value = 0;
  };
  const Float odd{std::numeric_limits<f32>::signaling_NaN()};
  const auto bytes = encoded(odd, std::endian::big);
  const auto again = decode<Float>(bytes, std::endian::big);
  ASSERT_TRUE(again);
  EXPECT_EQ(encoded(*again, std::endian::big), bytes);
}

}  // namespace codec_test
}  // namespace rack
