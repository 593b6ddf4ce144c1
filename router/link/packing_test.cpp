#include "router/link/packing.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "router/compression/sample_bytes.h"
#include "wire/header.h"

namespace tims::link {
namespace packing_test {

using compression::Method;

constexpr Address kLadar{0x03140000};
constexpr Address kPilot{0x03300000};
constexpr Address kOwnClass{0x03900000};

// A message in memory.
struct Sent {
  Sent(const Header& h, std::span<const std::byte> body) : bytes(kHeaderSize + body.size()) {
    message.header = h;
    message.header.length = static_cast<std::uint32_t>(bytes.size());
    wire::encode_header(message.header, std::span(bytes).first<kHeaderSize>());
    std::ranges::copy(body, bytes.begin() + kHeaderSize);
    message.bytes = bytes;
  }
  std::vector<std::byte> bytes;
  core::Message message{};
};

Header data_header() {
  return {.flags = flag::kNativeOrder | flag::kStream,
          .type = type::kData,
          .priority = 30,
          .seq_nr = 7,
          .dest = kPilot,
          .src = kLadar};
}

struct PackingTest : testing::Test {
  std::optional<core::Message> pack(const Header& header, std::span<const std::byte> body,
                                    Method method = Method::kZstd) {
    last.emplace(header, body);
    return packing.pack(last->message, method, settings, counters);
  }
  bool packs(const Header& header, std::size_t body = 2000) {
    return pack(header, compression::scan_like(body)).has_value();
  }

  Packing packing{{}, {}};
  PackingSettings settings{.compress = core::Compression::kAuto};
  PackingCounters counters{};
  std::optional<Sent> last;
};

TEST_F(PackingTest, AMessageIsRestored) {
  for (const Method method : {Method::kLz4, Method::kZstd}) {
    const Sent sent(data_header(), compression::scan_like(5784));
    auto packed = packing.pack(sent.message, method, settings, counters);
    ASSERT_TRUE(packed && packed->packed);
    EXPECT_LT(packed->bytes.size(), sent.bytes.size() / 3);
    EXPECT_EQ(packed->header.length, packed->bytes.size());
    EXPECT_EQ(wire::decode_header(packed->bytes.first<kHeaderSize>()), packed->header);
    EXPECT_EQ(packing.unpacked_size(*packed), sent.bytes.size());

    std::vector<std::byte> back(sent.bytes.size());
    ASSERT_TRUE(packing.unpack(*packed, back, counters));
    EXPECT_FALSE(packed->packed);
    EXPECT_EQ(packed->header, sent.message.header);
    EXPECT_EQ(back, sent.bytes);
  }
  EXPECT_EQ(counters.packed, 2U);
  EXPECT_EQ(counters.unpacked, 2U);
  EXPECT_EQ(counters.bytes_before, counters.bytes_unpacked);
}

TEST_F(PackingTest, ForSeveralReceiversItIsCompressedOnce) {
  const auto body = compression::scan_like(5784);
  Header header = data_header();
  for (std::uint32_t receiver = 0; receiver < 5; ++receiver) {
    header.dest = Address(kPilot.raw() + receiver);
    ++header.seq_nr;
    auto packed = pack(header, body);
    ASSERT_TRUE(packed);
    EXPECT_EQ(counters.reused, receiver);
    std::vector<std::byte> back(last->bytes.size());
    ASSERT_TRUE(packing.unpack(*packed, back, counters));
    EXPECT_EQ(back, last->bytes);
  }
  EXPECT_EQ(counters.packed, 5U);
}

TEST_F(PackingTest, OnlyTheSameBytesOfTheSameSourceAreReused) {
  const auto body = compression::scan_like(5784);
  Header other = data_header();
  other.src = Address(kLadar.raw() + 1);
  auto differs = body;
  differs.back() ^= std::byte{1};
  ASSERT_TRUE(pack(data_header(), body));
  ASSERT_TRUE(pack(data_header(), body, Method::kLz4));
  ASSERT_TRUE(pack(data_header(), differs, Method::kLz4));
  ASSERT_TRUE(pack(other, differs, Method::kLz4));
  ASSERT_TRUE(pack(other, std::span(differs).first(5000), Method::kLz4));
  EXPECT_FALSE(pack(data_header(), compression::noise(5000), Method::kLz4)) << "overwrites it";
  auto packed = pack(other, std::span(differs).first(5000), Method::kLz4);
  ASSERT_TRUE(packed);
  EXPECT_EQ(counters.reused, 0U);
  std::vector<std::byte> back(last->bytes.size());
  ASSERT_TRUE(packing.unpack(*packed, back, counters));
  EXPECT_EQ(back, last->bytes);
}

TEST_F(PackingTest, SizesHaveBounds) {
  EXPECT_FALSE(packs(data_header(), Packing::kMessageMin - kHeaderSize - 1));
  EXPECT_TRUE(packs(data_header(), Packing::kMessageMin - kHeaderSize));
  EXPECT_TRUE(packs(data_header(), compression::kBlockMax));
  EXPECT_FALSE(packs(data_header(), compression::kBlockMax + 1));
}

// Sizes show through encryption: what may hold a secret is left alone, whatever it contains.
TEST_F(PackingTest, OnlySensorDataAreCompressed) {
  const auto with = [](auto change) {
    Header header = data_header();
    change(header);
    return header;
  };
  EXPECT_TRUE(packs(data_header()));
  EXPECT_TRUE(packs(with([](Header& h) { h.type = type::kContData; })));
  for (int type = -128; type < 128; ++type) {
    if (type == type::kData || type == type::kContData) continue;
    EXPECT_FALSE(packs(with([&](Header& h) { h.type = static_cast<std::int8_t>(type); }))) << type;
  }
  EXPECT_TRUE(packs(with([](Header& h) { h.priority = 44; })));
  EXPECT_FALSE(packs(with([](Header& h) { h.priority = 45; }))) << "urgent";
  EXPECT_FALSE(packs(with([](Header& h) { h.priority = 255; })));
  EXPECT_FALSE(packs(with([](Header& h) { h.dest = text_sink(); })));
  EXPECT_FALSE(packs(with([](Header& h) { h.src = kOwnClass; })));
  settings.own_classes = true;
  EXPECT_TRUE(packs(with([](Header& h) { h.src = kOwnClass; })));
}

TEST_F(PackingTest, WhatGainsNothingIsTriedAgainAfter64Messages) {
  const auto body = compression::noise(2000);
  for (std::uint32_t i = 0; i < 2 * Packing::kTriedAgainAfter + 1; ++i)
    EXPECT_FALSE(pack(data_header(), body));
  EXPECT_EQ(counters.incompressible, 3U);
  // The source sends something else from now on.
  std::uint32_t until = 0;
  while (!pack(data_header(), compression::scan_like(2000)))
    ASSERT_LE(++until, Packing::kTriedAgainAfter);
  EXPECT_EQ(until, Packing::kTriedAgainAfter - 1);
  EXPECT_TRUE(pack(data_header(), compression::scan_like(2000)));
}

TEST_F(PackingTest, SourcesDoNotShareTheirHistory) {
  EXPECT_FALSE(pack(data_header(), compression::noise(2000)));
  Header other = data_header();
  other.src = Address(0x03140100);
  EXPECT_TRUE(packs(other));
}

TEST_F(PackingTest, DamagedMessagesAreRefused) {
  auto packed = *pack(data_header(), compression::scan_like(2000));
  const std::vector<std::byte> good(packed.bytes.begin(), packed.bytes.end());
  std::vector<std::byte> bytes;
  const auto size_of = [&](auto damage) {
    bytes = good;
    damage(bytes);
    packed.bytes = bytes;
    return packing.unpacked_size(packed);
  };
  const auto set_size = [&](std::uint32_t size) {
    return size_of([&](auto& b) {
      for (std::size_t i = 0; i < 4; ++i)
        b[kHeaderSize + 4 + i] = static_cast<std::byte>(size >> 8 * i);
    });
  };
  EXPECT_EQ(size_of([](auto&) {}), 2016U);
  EXPECT_FALSE(size_of([](auto& b) { b.resize(Packing::kHeadSize); })) << "nothing compressed";
  EXPECT_FALSE(size_of([](auto& b) { b.resize(kHeaderSize); }));
  EXPECT_FALSE(size_of([](auto& b) { b[kHeaderSize] = std::byte{7}; })) << "no such method";
  EXPECT_FALSE(size_of([](auto& b) { b[kHeaderSize + 1] = std::byte{49}; })) << "stride";
  EXPECT_FALSE(set_size(0));
  EXPECT_FALSE(set_size(kHeaderSize));
  EXPECT_FALSE(set_size(0xFFFFFFFF));
  const std::size_t compressed = good.size() - Packing::kHeadSize;
  const auto most = static_cast<std::uint32_t>(kHeaderSize + compressed * compression::kRatioMax);
  EXPECT_TRUE(set_size(most));
  EXPECT_FALSE(set_size(most + 1)) << "a bomb";

  // A size that is not the true one, but possible.
  ASSERT_EQ(set_size(2017), 2017U);
  std::vector<std::byte> to(2017);
  EXPECT_FALSE(packing.unpack(packed, to, counters));
  EXPECT_EQ(counters.broken, 1U);
}

TEST_F(PackingTest, WhatMustNotBeCompressedIsNotTakenEither) {
  auto packed = *pack(data_header(), compression::scan_like(2000));
  packed.header.type = type::kGetData;
  EXPECT_FALSE(packing.unpacked_size(packed));
  packed.header.type = type::kAdminReply;
  EXPECT_FALSE(packing.unpacked_size(packed));
  packed.header = data_header();
  packed.header.priority = 100;
  EXPECT_FALSE(packing.unpacked_size(packed));
  packed.header = data_header();
  packed.header.dest = text_sink();
  EXPECT_FALSE(packing.unpacked_size(packed));
}

TEST(PackingMethod, FollowsTheRateOfTheLink) {
  using core::Compression;
  const auto automatic = [](std::uint64_t rate) {
    return method_for(Compression::kAuto, kCodecs, rate);
  };
  EXPECT_EQ(automatic(kRateWithout), std::nullopt);
  EXPECT_EQ(automatic(kRateWithout - 1), Method::kLz4);
  EXPECT_EQ(automatic(kRateLz4), Method::kLz4);
  EXPECT_EQ(automatic(kRateLz4 - 1), Method::kZstd);
  EXPECT_EQ(method_for(Compression::kOff, kCodecs, 1000), std::nullopt);
  EXPECT_EQ(method_for(Compression::kLz4, kCodecs, kRateWithout), Method::kLz4);
  EXPECT_EQ(method_for(Compression::kZstd, kCodecs, kRateWithout), Method::kZstd);
  EXPECT_EQ(method_for(Compression::kZstd, 0, 1000), std::nullopt) << "the other side is older";
  EXPECT_EQ(method_for(Compression::kZstd, 1, 1000), std::nullopt) << "it knows LZ4 only";
}

}  // namespace packing_test
}  // namespace tims::link
