#include "router/link/announcement.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace {

NetAddress v6(std::uint8_t last, std::uint16_t port) {
  NetAddress address{.port = port};
  address.ip[0] = 0xFD;
  address.ip[15] = last;
  return address;
}

Announcement example() {
  return {.fleet = std::string_view("harbour"),
          .who = {.epoch = 7,
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
  announcement.who.name = std::string_view(std::string(63, 'n'));
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

}  // namespace
}  // namespace tims::link
