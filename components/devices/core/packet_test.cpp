#include "components/devices/core/packet.h"

#include <vector>

#include <gtest/gtest.h>

#include "base/text.h"

namespace rack::device {
namespace packet_test {

std::vector<std::byte> bytes(std::string_view hex) { return *tims::base::parse_hex(hex); }

std::string text_of(std::span<const std::byte> all) {
  std::string text;
  for (const std::byte byte : all) text += static_cast<char>(byte);
  return text;
}

constexpr std::string_view kUdpBody = "0940 0941 000A 0000 6869";  // "hi"
constexpr std::string_view kIpv4Udp = "45000020 00004000 40110000 0A000001 0A000002";

TEST(PacketTest, UdpInEthernetWithAndWithoutTags) {
  const std::string ip = std::string(kIpv4Udp) + std::string(kUdpBody) + "0000";  // padded
  for (const char* type : {"0800", "8100 0001 0800", "88A8 0001 8100 0002 0800"}) {
    const auto packet = bytes("FFFFFFFFFFFF 000000000000 " + std::string(type) + ip);
    auto payload = payload_of(PacketLink::kEthernet, packet);
    ASSERT_TRUE(payload) << type;
    EXPECT_FALSE(payload->is_tcp);
    EXPECT_EQ(payload->from_port, 0x940);
    EXPECT_EQ(payload->to_port, 0x941);
    EXPECT_EQ(text_of(payload->bytes), "hi");
  }
}

TEST(PacketTest, Ipv6AndBareIp) {
  const auto packet = bytes("60000000 000A 11 40 " + std::string(64, '0') + std::string(kUdpBody));
  const auto payload = payload_of(PacketLink::kRawIp, packet);
  ASSERT_TRUE(payload);
  EXPECT_EQ(text_of(payload->bytes), "hi");
}

TEST(PacketTest, TcpWithOptions) {
  const auto packet = bytes(
      "45000030 00004000 40060000 0A000001 0A000002"
      "0840 1000 00000064 00000000 6018 0000 0000 0000 01010101 68656C6C");
  const auto payload = payload_of(PacketLink::kRawIp, packet);
  ASSERT_TRUE(payload);
  EXPECT_TRUE(payload->is_tcp);
  EXPECT_EQ(payload->sequence, 100U);
  EXPECT_EQ(text_of(payload->bytes), "hell");
}

TEST(PacketTest, WhatIsCutAnywhereIsNothing) {
  const auto packet = bytes(std::string(kIpv4Udp) + std::string(kUdpBody));
  for (std::size_t size = 0; size < 28; ++size)
    EXPECT_FALSE(payload_of(PacketLink::kRawIp, std::span(packet).first(size))) << size;
  const auto fragment =
      bytes("45000020 00002001 40110000 0A000001 0A000002" + std::string(kUdpBody));
  EXPECT_FALSE(payload_of(PacketLink::kRawIp, fragment));
}

TEST(PacketTest, BytesOfAStreamComeOnce) {
  const auto all = bytes("000102030405060708");
  StreamOrder order;
  const auto take = [&](std::uint32_t sequence, std::size_t begin, std::size_t size) {
    return order
        .take({.is_tcp = true,
               .from_port = 1,
               .to_port = 2,
               .sequence = sequence,
               .bytes = std::span(all).subspan(begin, size)})
        .size();
  };
  EXPECT_EQ(take(0xFFFFFFFE, 0, 4), 4U);
  EXPECT_EQ(take(0xFFFFFFFE, 0, 4), 0U);  // retransmitted
  EXPECT_EQ(take(0, 2, 4), 2U);           // half of it is new
  EXPECT_EQ(take(4, 6, 2), 2U);
  EXPECT_EQ(take(100, 6, 2), 2U);         // something is missing
  EXPECT_EQ(take(50'000'000, 6, 2), 2U);  // a new connection
}

}  // namespace packet_test
}  // namespace rack::device
