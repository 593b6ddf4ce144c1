#include "components/devices/core/packet.h"

#include <cstdio>
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
constexpr std::string_view kIpv4Udp = "4500001E 00004000 40110000 0A000001 0A000002";

TEST(PacketTest, UdpInEthernetWithAndWithoutTags) {
  const std::string ip = std::string(kIpv4Udp) + std::string(kUdpBody) + "0000";  // padded
  for (const char* type : {"0800", "8100 0001 0800", "88A8 0001 8100 0002 0800"}) {
    const auto packet = bytes("FFFFFFFFFFFF 000000000000 " + std::string(type) + ip);
    const auto payload = PacketReader(PacketLink::kEthernet).take(packet);
    ASSERT_TRUE(payload) << type;
    EXPECT_FALSE(payload->is_tcp);
    EXPECT_EQ(payload->from_port, 0x940);
    EXPECT_EQ(payload->to_port, 0x941);
    EXPECT_EQ(text_of(payload->bytes), "hi");
  }
}

TEST(PacketTest, Ipv6AndBareIp) {
  const auto packet = bytes("60000000 000A 11 40 " + std::string(64, '0') + std::string(kUdpBody));
  const auto payload = PacketReader(PacketLink::kRawIp).take(packet);
  ASSERT_TRUE(payload);
  EXPECT_EQ(text_of(payload->bytes), "hi");
}

TEST(PacketTest, TcpWithOptions) {
  const auto packet = bytes(
      "45000030 00004000 40060000 0A000001 0A000002"
      "0840 1000 00000064 00000000 6018 0000 0000 0000 01010101 68656C6C");
  const auto payload = PacketReader(PacketLink::kRawIp).take(packet);
  ASSERT_TRUE(payload);
  EXPECT_TRUE(payload->is_tcp);
  EXPECT_EQ(payload->sequence, 100U);
  EXPECT_EQ(text_of(payload->bytes), "hell");
}

TEST(PacketTest, WhatIsCutAnywhereIsNothingAndCounted) {
  const auto packet = bytes(std::string(kIpv4Udp) + std::string(kUdpBody));
  for (std::size_t size = 1; size < packet.size(); ++size) {
    PacketReader reader(PacketLink::kRawIp);
    EXPECT_FALSE(reader.take(std::span(packet).first(size))) << size;
    EXPECT_EQ(reader.truncated(), 1U) << size;
  }
  PacketReader reader(PacketLink::kRawIp);
  EXPECT_FALSE(reader.take({}));
  EXPECT_TRUE(reader.take(packet));
}

TEST(PacketTest, EveryLinkThatCapturesOfIpHave) {
  const std::string ip = std::string(kIpv4Udp) + std::string(kUdpBody);
  const std::string cooked = "0000 0001 0006 000000000000 0000 0800";
  const std::string cooked2 = "0800 0000 00000002 0001 00 06 0000000000000000";
  const std::vector<std::pair<int, std::string>> heads = {
      {0, "02000000"}, {0, "00000002"}, {108, "00000002"}, {12, ""},      {14, ""},
      {101, ""},       {228, ""},       {113, cooked},     {276, cooked2}};
  for (const auto& [number, head] : heads) {
    const auto link = packet_link(number);
    ASSERT_TRUE(link) << number;
    const auto packet = bytes(head + ip);
    PacketReader reader(*link);
    const auto payload = reader.take(packet);
    ASSERT_TRUE(payload) << number;
    EXPECT_EQ(text_of(payload->bytes), "hi") << number;
  }
  EXPECT_FALSE(packet_link(105));  // IEEE 802.11
}

TEST(PacketTest, FragmentsInAnyOrderAreOneDatagram) {
  // 16 bytes of UDP in two fragments, of two datagrams at the same time.
  const auto fragment = [](int id, int place, const std::string& body) {
    const std::size_t total = 20 + body.size() / 2;
    char head[64];
    std::snprintf(head, sizeof head, "4500%04zX%04X%04X40110000", total, id, place);
    return bytes(std::string(head) + "0A0000010A000002" + body);
  };
  const std::string first = "0940094100100000";
  PacketReader reader(PacketLink::kRawIp);
  EXPECT_FALSE(reader.take(fragment(1, 0x2000, first)));
  EXPECT_FALSE(reader.take(fragment(2, 0x0001, "4242424242424242")));
  const auto one = reader.take(fragment(1, 0x0001, "4141414141414141"));
  ASSERT_TRUE(one);
  EXPECT_EQ(text_of(one->bytes), "AAAAAAAA");
  EXPECT_EQ(reader.incomplete(), 1U);
  const auto two = reader.take(fragment(2, 0x2000, first));
  ASSERT_TRUE(two);
  EXPECT_EQ(text_of(two->bytes), "BBBBBBBB");
  EXPECT_EQ(reader.incomplete(), 0U);
  EXPECT_FALSE(reader.take(fragment(3, 0x2001, "41414141")));  // ends between two units
  EXPECT_EQ(reader.incomplete(), 1U);
}

TEST(PacketTest, FragmentsAndOptionsOfIpv6) {
  const std::string addresses(64, '1');
  PacketReader reader(PacketLink::kRawIp);
  // A hop-by-hop header, then a fragment header.
  EXPECT_FALSE(reader.take(bytes("60000000 0018 00 40" + addresses + "2C00000000000000" +
                                 "1100 0001 00000007" + "0940094100100000")));
  const auto whole = reader.take(
      bytes("60000000 0010 2C 40" + addresses + "1100 0008 00000007" + "4343434343434343"));
  ASSERT_TRUE(whole);
  EXPECT_EQ(text_of(whole->bytes), "CCCCCCCC");
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
