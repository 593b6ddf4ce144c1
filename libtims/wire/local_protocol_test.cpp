#include "wire/local_protocol.h"

#include <random>

#include <gtest/gtest.h>

namespace tims::wire {
namespace local_protocol_test {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(const Packet& packet) {
  Bytes bytes;
  encode(packet, bytes);
  return bytes;
}

// One record of each kind, with a different value in every field.
std::vector<Packet> one_of_each() {
  const MailboxPlace place{0x1122334455667788, 0x8877665544332211};
  return {
      {1, Hello{2, 3, 0x00ABCDEF, "laser"}},
      {2, Welcome{4, 5, Address(6), 0x99AABBCCDDEEFF00, 1 << 24, {5, 6, 9, 12}}},
      {3, Refused{"no common version: update the library"}},
      {4, OfferSegment{0x0102030405060708}},
      {5, Open{{{Address(7), place, true}, {Address(8), {9, 10}, false}}}},
      {6, Opened{{{Address(11), OpenStatus::kOk}, {Address(12), OpenStatus::kNotTried}}, "pid 5"}},
      {7, Close{{Address(13), Address(14), Address(15)}}},
      {8, Closed{}},
      {9, Lookup{{Address(16)}}},
      {10, Found{Address(17), true, place, false}},
      {11, UplinkRequest{}},
      {12, Uplink{place}},
      {0xFFFFFFFF, Moved{Address(18)}},
  };
}

template <typename T>
T round_trip(const T& record) {
  const Decoded decoded = decode(bytes_of({77, record}));
  EXPECT_TRUE(decoded.packet) << decoded.problem;
  if (!decoded.packet || !std::holds_alternative<T>(decoded.packet->record)) {
    ADD_FAILURE() << "came back as another record";
    return {};
  }
  EXPECT_EQ(decoded.packet->request, 77U);
  return std::get<T>(decoded.packet->record);
}

TEST(LocalProtocol, EveryRecordIsInTheListOfThisTest) {
  const std::vector<Packet> packets = one_of_each();
  ASSERT_EQ(packets.size(), std::variant_size_v<Record>);
  for (std::size_t i = 0; i < packets.size(); ++i) EXPECT_EQ(packets[i].record.index(), i);
}

TEST(LocalProtocol, WhatWasDecodedEncodesToTheSameBytes) {
  for (const Packet& packet : one_of_each()) {
    const Bytes bytes = bytes_of(packet);
    const Decoded decoded = decode(bytes);
    ASSERT_TRUE(decoded.packet) << decoded.problem;
    EXPECT_EQ(decoded.packet->request, packet.request);
    EXPECT_EQ(decoded.packet->record.index(), packet.record.index());
    EXPECT_EQ(bytes_of(*decoded.packet), bytes);
  }
}

TEST(LocalProtocol, BeginningOfASession) {
  const auto hello = round_trip(Hello{2, 3, 4, "laser"});
  EXPECT_EQ(hello.version_min, 2);
  EXPECT_EQ(hello.version_max, 3);
  EXPECT_EQ(hello.writer, 4U);
  EXPECT_EQ(hello.name, "laser");
  const auto welcome = round_trip(Welcome{5, 6, Address(7), 1ULL << 63, 8, {4, 5, 11, 12}});
  EXPECT_EQ(welcome.version, 5);
  EXPECT_EQ(welcome.writer, 6U);
  EXPECT_EQ(welcome.router, Address(7));
  EXPECT_EQ(welcome.epoch, 1ULL << 63);
  EXPECT_EQ(welcome.message_max, 8U);
  EXPECT_EQ(welcome.widths, (AddressWidths{4, 5, 11, 12}));
  EXPECT_EQ(round_trip(Refused{"no"}).text, "no");
  EXPECT_EQ(round_trip(OfferSegment{1ULL << 40}).segment, 1ULL << 40);
}

TEST(LocalProtocol, OpeningAndClosing) {
  const auto open = round_trip(Open{{{Address(1), {2, 3}, true}, {Address(4), {5, 6}, false}}});
  ASSERT_EQ(open.entries.size(), 2U);
  EXPECT_EQ(open.entries[0].address, Address(1));
  EXPECT_EQ(open.entries[0].place, (MailboxPlace{2, 3}));
  EXPECT_TRUE(open.entries[0].has_waker);
  EXPECT_EQ(open.entries[1].address, Address(4));
  EXPECT_EQ(open.entries[1].place, (MailboxPlace{5, 6}));
  EXPECT_FALSE(open.entries[1].has_waker);
  const auto opened = round_trip(Opened{{{Address(7), OpenStatus::kTooMany}}, "pid 9 (laser)"});
  ASSERT_EQ(opened.entries.size(), 1U);
  EXPECT_EQ(opened.entries[0].address, Address(7));
  EXPECT_EQ(opened.entries[0].status, OpenStatus::kTooMany);
  EXPECT_EQ(opened.text, "pid 9 (laser)");
  EXPECT_EQ(round_trip(Close{{Address(1), Address(2)}}).addresses,
            (std::vector{Address(1), Address(2)}));
}

TEST(LocalProtocol, LookingUp) {
  EXPECT_EQ(round_trip(Lookup{{Address(3)}}).addresses, std::vector{Address(3)});
  const auto found = round_trip(Found{Address(4), true, {5, 6}, false});
  EXPECT_EQ(found.address, Address(4));
  EXPECT_TRUE(found.local);
  EXPECT_EQ(found.place, (MailboxPlace{5, 6}));
  EXPECT_FALSE(found.has_waker);
  EXPECT_EQ(round_trip(Uplink{{7, 8}}).place, (MailboxPlace{7, 8}));
  EXPECT_EQ(round_trip(Moved{Address(9)}).address, Address(9));
}

TEST(LocalProtocol, EveryTruncationIsRefused) {
  for (const Packet& packet : one_of_each()) {
    const Bytes bytes = bytes_of(packet);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const Decoded decoded = decode(std::span(bytes).first(size));
      EXPECT_FALSE(decoded.packet) << "record " << packet.record.index() << ", " << size;
      EXPECT_FALSE(decoded.problem.empty());
    }
  }
}

TEST(LocalProtocol, SurplusIsRefused) {
  for (const Packet& packet : one_of_each()) {
    Bytes bytes = bytes_of(packet);
    bytes.push_back(std::byte{0});
    EXPECT_EQ(decode(bytes).problem, "bytes behind the record");
  }
}

// Copies of a valid record with one number changed.
Bytes with_u16(Bytes bytes, std::size_t at, std::uint16_t number) {
  std::copy_n(std::as_bytes(std::span(&number, 1)).begin(), 2,
              bytes.begin() + static_cast<std::ptrdiff_t>(at));
  return bytes;
}

TEST(LocalProtocol, RefusesWhatNoEncoderWrites) {
  const Bytes request = bytes_of({1, UplinkRequest{}});
  for (const unsigned kind : {0U, 14U, 255U, 65535U})
    EXPECT_EQ(decode(with_u16(request, 0, static_cast<std::uint16_t>(kind))).problem,
              "unknown kind of record");
  EXPECT_EQ(decode(with_u16(request, 2, 1)).problem, "a record from another version");
  EXPECT_EQ(decode(with_u16(bytes_of({1, Lookup{}}), 8, kBatchMax + 1)).problem,
            "a list that is too long");
  EXPECT_EQ(decode(with_u16(bytes_of({1, Refused{}}), 8, kTextMax + 1)).problem,
            "a text that is too long");
  EXPECT_EQ(decode(with_u16(bytes_of({1, Hello{}}), 16, kNameMax + 1)).problem,
            "a text that is too long");
  EXPECT_EQ(decode(with_u16(bytes_of({1, Opened{{{}}, ""}}), 14, 5)).problem, "unknown status");
  EXPECT_EQ(decode(with_u16(bytes_of({1, Found{}}), 12, 0x0202)).problem,
            "a yes or no that is neither");
  EXPECT_EQ(decode(bytes_of({1, Welcome{.router = {}, .widths = {8, 8, 8, 9}}})).problem,
            "address fields that are not 32 bits");
}

TEST(LocalProtocol, LimitsFitAndWhatIsBeyondThemIsCut) {
  EXPECT_EQ(round_trip(Hello{.name = std::string(kNameMax, 'x')}).name.size(), kNameMax);
  EXPECT_EQ(round_trip(Hello{.name = std::string(kNameMax + 1, 'x')}).name.size(), kNameMax);
  EXPECT_EQ(round_trip(Refused{std::string(100000, 'x')}).text.size(), kTextMax);
  Open open;
  open.entries.resize(kBatchMax);
  EXPECT_EQ(round_trip(open).entries.size(), kBatchMax);
  EXPECT_LE(bytes_of({1, open}).size(), kRecordBytesMax);
  open.entries.resize(100000);
  EXPECT_EQ(round_trip(open).entries.size(), kBatchMax);
}

TEST(LocalProtocol, DamagedRecordsAreRefusedOrEncodeToTheSameBytes) {
  std::mt19937 random(1);
  std::size_t accepted = 0;
  for (int round = 0; round < 2000; ++round)
    for (const Packet& packet : one_of_each()) {
      Bytes bytes = bytes_of(packet);
      for (std::size_t changes = 1 + random() % 3; changes > 0; --changes)
        bytes[random() % bytes.size()] = static_cast<std::byte>(random() % 4 == 0 ? random() : 1);
      const Decoded decoded = decode(bytes);
      EXPECT_NE(decoded.packet.has_value(), !decoded.problem.empty());
      if (!decoded.packet) continue;
      ++accepted;
      ASSERT_EQ(bytes_of(*decoded.packet), bytes);
    }
  EXPECT_GT(accepted, 1000U) << "the damage is too strong to test anything";
}

}  // namespace local_protocol_test
}  // namespace tims::wire
