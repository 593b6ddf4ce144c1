#include "router/link/datagram.h"

#include <array>
#include <optional>

#include <gtest/gtest.h>

namespace tims::link {
namespace datagram_test {

const Identity kRobot{.epoch = 5,
                      .role = Role::kSubsystem,
                      .system = 3,
                      .id = 2,
                      .name = std::string_view("arm"),
                      .message_max = 1 << 20,
                      .classes = {{1, 2, 3, 50, 60, 70, 255}}};

std::span<std::byte> written(const Identity& identity, std::span<std::byte> to) {
  ByteWriter out(to);
  put(out, identity);
  return out.written();
}

TEST(IdentityBytes, IsReadAsItWasWritten) {
  std::array<std::byte, kIdentityBytesMax> bytes{};
  ByteReader in(written(kRobot, bytes));
  Identity identity;
  EXPECT_TRUE(get(in, identity));
  EXPECT_EQ(identity, kRobot);
  EXPECT_TRUE(in.empty());
}

// Fields of up to 16 bits; those of 8 bits have the same bytes as in earlier versions.
TEST(IdentityBytes, IdsAbove255) {
  Identity wide = kRobot;
  wide.widths = {12, 8, 6, 6};
  wide.classes = wide.classes.at(wide.widths);
  wide.system = 1000;
  const auto read = [](const Identity& identity) {
    std::array<std::byte, kIdentityBytesMax> bytes{};
    ByteReader in(written(identity, bytes));
    Identity back;
    const bool good = get(in, back) && in.empty();
    return good ? std::optional(back) : std::nullopt;
  };
  EXPECT_EQ(read(wide), wide);
  wide.system = 4096;
  EXPECT_EQ(read(wide), std::nullopt) << "does not fit";
  wide.system = 3;
  wide.id = 64;
  EXPECT_EQ(read(wide), std::nullopt);
  wide.widths = {8, 4, 16, 4};
  wide.classes = wide.classes.at(wide.widths);
  wide.id = 65535;
  EXPECT_EQ(read(wide), wide);
  std::array<std::byte, kIdentityBytesMax> bytes{};
  EXPECT_EQ(written(kRobot, bytes).size(), 27U + 3) << "nothing follows the name";
  EXPECT_EQ(bytes[8], std::byte{0});
}

TEST(IdentityBytes, TheLongestNameHasRoom) {
  Identity identity = kRobot;
  identity.widths = {12, 8, 6, 6};
  identity.system = 1000;
  identity.name =
      std::string_view("a name of sixty-three letters, which is the longest there may be!");
  std::array<std::byte, kIdentityBytesMax> bytes{};
  EXPECT_EQ(written(identity, bytes).size(), kIdentityBytesMax);
}

TEST(IdentityBytes, BytesThatAreNotAnIdentity) {
  std::array<std::byte, kIdentityBytesMax> bytes{};
  const auto all = written(kRobot, bytes);
  Identity identity;
  for (std::size_t size = 0; size < all.size(); ++size) {
    ByteReader in(all.first(size));
    EXPECT_FALSE(get(in, identity)) << "cut to " << size;
  }
  const auto refused = [&](std::size_t at, std::uint8_t value) {
    auto damaged = bytes;
    damaged[at] = std::byte{value};
    ByteReader in(damaged);
    return !get(in, identity);
  };
  EXPECT_TRUE(refused(0, 0)) << "epoch 0";
  EXPECT_TRUE(refused(8, 3)) << "no such role";
  EXPECT_TRUE(refused(12, 200)) << "widths of more than 32 bits";
  EXPECT_TRUE(refused(21, 1)) << "thresholds that do not ascend";
}

using namespace std::chrono_literals;

Hello hello() {
  return {.kind = LinkKind::kPeer,
          .token = 11,
          .resume = 12,
          .cookie = 13,
          .keep_alive = 300ms,
          .identity = {.epoch = 5,
                       .role = Role::kTop,
                       .system = 3,
                       .id = 4,
                       .name = std::string_view("base"),
                       .message_max = 1000}};
}

TEST(Datagram, AHelloReadsBackAndMayNotBeCut) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  const std::size_t size = encode(hello(), bytes);
  const auto datagram = decode(std::span(bytes).first(size));
  ASSERT_TRUE(datagram.has_value());
  const auto& back = std::get<Hello>(*datagram);
  EXPECT_EQ(back.token, 11U);
  EXPECT_EQ(back.resume, 12U);
  EXPECT_EQ(back.cookie, 13U);
  EXPECT_EQ(back.keep_alive, 300ms);
  EXPECT_EQ(back.identity.name.view(), "base");
  EXPECT_EQ(back.identity.id, 4);
  for (std::size_t n = 0; n < size; ++n)
    EXPECT_FALSE(decode(std::span(bytes).first(n)).has_value()) << n;
}

TEST(Datagram, ARetryReadsBackAndMayNotBeCut) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  const std::size_t size = encode(Retry{.echo = 11, .cookie = 12}, bytes);
  const auto datagram = decode(std::span(bytes).first(size));
  ASSERT_TRUE(datagram.has_value());
  EXPECT_EQ(std::get<Retry>(*datagram).echo, 11U);
  EXPECT_EQ(std::get<Retry>(*datagram).cookie, 12U);
  for (std::size_t n = 0; n < size; ++n)
    EXPECT_FALSE(decode(std::span(bytes).first(n)).has_value()) << n;
}

TEST(Datagram, ARouterHasAnEpoch) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  Hello nobody = hello();
  nobody.identity.epoch = 0;
  EXPECT_FALSE(decode(std::span(bytes).first(encode(nobody, bytes))).has_value());
}

TEST(Datagram, KeepAlivesAreNeverTooShort) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  Hello hasty = hello();
  hasty.keep_alive = 0ms;
  const auto datagram = decode(std::span(bytes).first(encode(hasty, bytes)));
  EXPECT_EQ(std::get<Hello>(*datagram).keep_alive, 10ms);
}

TEST(Datagram, AnUnknownVersionKeepsItsToken) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  const std::size_t size = encode(hello(), bytes);
  bytes[1] = bytes[2] = std::byte{9};
  const auto datagram = decode(std::span(bytes).first(size));
  ASSERT_TRUE(datagram.has_value());
  EXPECT_EQ(std::get<Hello>(*datagram).version_min, 9);
  EXPECT_EQ(std::get<Hello>(*datagram).token, 11U);
}

NetAddress v6(std::uint8_t last, std::uint16_t port) {
  NetAddress address{.port = port};
  address.ip[0] = 0xFD;
  address.ip[15] = last;
  return address;
}

Announcement example() {
  return {.fleet = std::string_view("harbour"),
          .identity = {.epoch = 7,
                       .role = Role::kSystem,
                       .system = 4,
                       .id = 1,
                       .name = std::string_view("robot4"),
                       .message_max = 16U << 20},
          .udp = {NetAddress::v4(10, 9, 1, 4, 2010), v6(4, 2011)}};
}

TEST(Announcement, IsReadAsItWasWritten) {
  EXPECT_EQ(decode_announcement(encode(example())), example());
  Announcement bare = example();
  bare.fleet = {};
  bare.udp.clear();
  EXPECT_EQ(decode_announcement(encode(bare)), bare);
}

TEST(Announcement, WhereItWasAnnouncedFromIsNotInTheBytes) {
  Announcement from_somewhere = example();
  from_somewhere.dds = NetAddress::dds({1, 2, 3});
  EXPECT_EQ(encode(from_somewhere), encode(example()));
}

TEST(Announcement, AddressesThatMeanNothingToOthersAreLeftOut) {
  Announcement announcement = example();
  NetAddress link_local = v6(1, 2010);
  link_local.scope = 2;
  announcement.udp.insert(announcement.udp.begin(),
                          {link_local, NetAddress(), NetAddress::dds({})});
  EXPECT_EQ(decode_announcement(encode(announcement)), example());
}

TEST(Announcement, ManyAddressesAreCutToWhatHasRoom) {
  Announcement announcement = example();
  announcement.fleet = std::string_view(std::string(63, 'f'));
  announcement.identity.name = std::string_view(std::string(63, 'n'));
  announcement.udp.assign(100, v6(9, 2010));
  const auto bytes = encode(announcement);
  EXPECT_LE(bytes.size(), kAnnouncementBytesMax);
  announcement.udp.resize(kAnnouncedAddressesMax);
  EXPECT_EQ(decode_announcement(bytes), announcement);
}

TEST(Announcement, BytesThatAreNone) {
  const auto bytes = encode(example());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(decode_announcement(std::span(bytes).first(size))) << "cut to " << size;
  auto longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode_announcement(longer));
  const auto refused = [&](std::size_t at, std::uint8_t value) {
    auto damaged = bytes;
    damaged[at] = std::byte{value};
    return !decode_announcement(damaged);
  };
  const std::size_t addresses = bytes.size() - (1 + 2 + 4) - (1 + 2 + 16);
  EXPECT_TRUE(refused(0, 'X')) << "another magic";
  EXPECT_TRUE(refused(4, 2)) << "another version";
  EXPECT_TRUE(refused(5, 17)) << "too many addresses";
  EXPECT_TRUE(refused(6, 64)) << "too long a fleet";
  EXPECT_TRUE(refused(addresses, 5)) << "no such family";
}

TEST(Announcement, NoPortIsNoAddress) {
  auto bytes = encode(example());
  const std::size_t port = bytes.size() - 18;
  bytes[port] = bytes[port + 1] = std::byte{0};
  EXPECT_FALSE(decode_announcement(bytes));
}

}  // namespace datagram_test
}  // namespace tims::link
