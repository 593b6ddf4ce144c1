#include "router/link/transport.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tims::link {
namespace transport_test {

TEST(NetAddress, IPv4IsPrintedAsPeopleWriteIt) {
  EXPECT_EQ(NetAddress::v4(10, 9, 1, 1, 2010).to_string(), "10.9.1.1:2010");
  EXPECT_TRUE(NetAddress::v4(10, 9, 1, 1, 2010).is_v4());
}

TEST(NetAddress, IPv6IsShortened) {
  NetAddress a{.port = 2010, .scope = 3};
  a.ip[0] = 0xFE;
  a.ip[1] = 0x80;
  a.ip[15] = 1;
  EXPECT_EQ(a.to_string(), "[fe80::1%3]:2010");
  EXPECT_FALSE(a.is_v4());
  NetAddress loopback{.port = 1};
  loopback.ip[15] = 1;
  EXPECT_EQ(loopback.to_string(), "[::1]:1");
  NetAddress full{.port = 5};
  for (std::size_t i = 0; i < 16; ++i) full.ip[i] = static_cast<std::uint8_t>(i + 1);
  EXPECT_EQ(full.to_string(), "[102:304:506:708:90a:b0c:d0e:f10]:5");
  full.kind = PathKind::kTcp;
  EXPECT_EQ(full.to_string(), "tcp:[102:304:506:708:90a:b0c:d0e:f10]:5");
}

TEST(NetAddress, ADdsParticipantIsAnAddressToo) {
  const DdsParticipant participant{1, 15, 0x6E, 0x1F, 10, 0, 0, 0, 1, 0, 0, 0xFF};
  const NetAddress address = NetAddress::dds(participant);
  EXPECT_TRUE(address);
  EXPECT_EQ(address.participant(), participant);
  EXPECT_EQ(address.to_string(), "dds:010f6e1f0a000000010000ff");
  NetAddress same_bytes = address;
  same_bytes.kind = PathKind::kUdp;
  EXPECT_NE(address, same_bytes);
}

TEST(NetAddress, WithoutAPortItIsNone) {
  EXPECT_FALSE(NetAddress());
  EXPECT_TRUE(NetAddress::v4(127, 0, 0, 1, 1));
}

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> made;
  for (const int value : values) made.push_back(static_cast<std::byte>(value));
  return made;
}

std::string sizes(std::vector<std::byte> of) {
  std::string text;
  Batch(of).for_each(
      [&](std::span<std::byte> datagram) { text += std::to_string(datagram.size()) + " "; });
  return text;
}

TEST(Batch, DatagramsOneBehindTheOther) {
  auto two = bytes({1, 0, 0xAA, 2, 0, 0xBB, 0xCC});
  EXPECT_TRUE(Batch(two).valid());
  EXPECT_EQ(sizes(two), "1 2 ");
  std::vector<std::byte> second;
  Batch(two).for_each([&](std::span<std::byte> d) { second.assign(d.begin(), d.end()); });
  EXPECT_EQ(second, bytes({0xBB, 0xCC}));
}

TEST(Batch, TheLargestDatagram) {
  std::vector<std::byte> large(kBatchSizeBytes + kBatchedMax);
  large[0] = large[1] = std::byte{0xFF};
  EXPECT_TRUE(Batch(large).valid());
  EXPECT_EQ(sizes(large), "65535 ");
}

TEST(Batch, ZerosUpToAMultipleOfFour) {
  for (auto padded :
       {bytes({1, 0, 9, 0}), bytes({2, 0, 9, 0, 0, 0}), bytes({3, 0, 0, 0, 0, 0, 0, 0})}) {
    EXPECT_TRUE(Batch(padded).valid()) << "of " << padded.size() << " bytes";
    EXPECT_EQ(sizes(padded), std::to_string(std::to_integer<int>(padded[0])) + " ");
  }
}

TEST(Batch, BytesThatAreNone) {
  for (auto bad :
       {bytes({}), bytes({1}), bytes({1, 0}), bytes({0, 0}), bytes({2, 0, 1}), bytes({1, 0, 9, 1}),
        bytes({1, 0, 9, 0, 0, 1}), bytes({1, 0, 9, 5, 0, 1}), bytes({0, 0, 1, 0, 9}),
        bytes({1, 0, 9, 0, 0, 0, 0}), bytes({0xFF, 0xFF, 1, 2, 3})}) {
    EXPECT_FALSE(Batch(bad).valid()) << "of " << bad.size() << " bytes";
  }
}

}  // namespace transport_test
}  // namespace tims::link
