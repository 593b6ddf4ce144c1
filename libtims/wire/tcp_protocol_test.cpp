#include "wire/tcp_protocol.h"

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tims::wire {

namespace tcp_protocol_test {

using Status = StreamReader::Status;
using Bytes = std::vector<std::byte>;

constexpr std::uint32_t kMax = 1 << 20;

// A whole message; the body's bytes are different for every `number`.
Bytes message(std::uint32_t length, std::uint8_t number, std::endian order = std::endian::native) {
  Bytes bytes(length);
  encode_header({.type = 5, .seq_nr = number, .dest = Address(number), .length = length},
                HeaderBytes(bytes.data(), kHeaderSize), order);
  for (std::size_t i = kHeaderSize; i < length; ++i) {
    bytes[i] = static_cast<std::byte>(i * 31 + number);
  }
  return bytes;
}

Bytes header_with_length(std::uint32_t length) {
  Bytes bytes(kHeaderSize);
  encode_header({.length = length}, HeaderBytes(bytes.data(), kHeaderSize));
  return bytes;
}

Bytes join(const std::vector<Bytes>& parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

// Feeds one chunk; appends the messages. Returns the status that ended it.
Status feed(StreamReader& reader, std::span<const std::byte> bytes, std::vector<Bytes>& out) {
  Bytes copy(bytes.begin(), bytes.end());
  std::span<std::byte> chunk = copy;
  for (;;) {
    const StreamReader::Item item = reader.next(chunk);
    if (item.status != Status::kMessage) return item.status;
    EXPECT_EQ(item.header.length, item.message.size());
    out.emplace_back(item.message.begin(), item.message.end());
  }
}

TEST(StreamReader, SplitAtEveryByte) {
  const std::vector<Bytes> messages = {message(16, 1), message(40, 2, std::endian::big),
                                       message(17, 3), message(16, 4, std::endian::big)};
  const Bytes all = join(messages);
  for (std::size_t split = 0; split <= all.size(); ++split) {
    StreamReader reader(kMax);
    std::vector<Bytes> out;
    EXPECT_EQ(feed(reader, std::span(all).first(split), out), Status::kNeedMore);
    EXPECT_EQ(feed(reader, std::span(all).subspan(split), out), Status::kNeedMore);
    EXPECT_EQ(out, messages) << "split at " << split;
    EXPECT_EQ(reader.pending(), 0U);
  }
}

TEST(StreamReader, ByteByByte) {
  const std::vector<Bytes> messages = {message(16, 1), message(5000, 2), message(33, 3)};
  StreamReader reader(kMax);
  std::vector<Bytes> out;
  for (const std::byte b : join(messages)) feed(reader, std::span(&b, 1), out);
  EXPECT_EQ(out, messages);
}

// Reads as a router does: into room() while it is not empty, else in chunks.
std::vector<Bytes> read_all(StreamReader& reader, const Bytes& all, std::mt19937& random,
                            std::size_t piece_max) {
  std::vector<Bytes> out;
  std::uniform_int_distribution<std::size_t> piece(1, piece_max);
  for (std::size_t at = 0; at < all.size();) {
    const std::span<std::byte> room = reader.room();
    std::size_t n = std::min(piece(random), all.size() - at);
    if (!room.empty()) {
      n = std::min(n, room.size());
      std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(at), n, room.begin());
      reader.advance(n);
      feed(reader, {}, out);
    } else {
      feed(reader, std::span(all).subspan(at, n), out);
    }
    at += n;
  }
  return out;
}

TEST(StreamReader, RandomSplits) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    std::vector<Bytes> messages;
    for (std::uint8_t i = 0; i < 40; ++i) {
      const std::uint32_t size_max = i % 10 == 0 ? 200000 : 300;
      const auto length = static_cast<std::uint32_t>(16 + random() % size_max);
      messages.push_back(message(length, i, i % 2 == 0 ? std::endian::big : std::endian::little));
    }
    StreamReader reader(kMax);
    const std::size_t piece_max = seed % 2 == 0 ? 70000 : 700;
    EXPECT_EQ(read_all(reader, join(messages), random, piece_max), messages) << "seed " << seed;
    EXPECT_EQ(reader.pending(), 0U);
  }
}

TEST(StreamReader, WholeMessagesAreHandedOutInPlace) {
  Bytes all = join({message(16, 1), message(100, 2), Bytes(10)});
  StreamReader reader(kMax);
  std::span<std::byte> chunk = all;
  StreamReader::Item item = reader.next(chunk);
  EXPECT_EQ(item.message.data(), all.data());
  item = reader.next(chunk);
  EXPECT_EQ(item.message.data(), all.data() + 16);
  EXPECT_EQ(item.message.size(), 100U);
  EXPECT_EQ(chunk.size(), 10U);
  EXPECT_EQ(reader.next(chunk).status, Status::kNeedMore);
  EXPECT_TRUE(chunk.empty());
  EXPECT_EQ(reader.pending(), 10U);
}

TEST(StreamReader, InPlaceUpToTheLastByteOfTheChunk) {
  Bytes all = message(100, 1);
  StreamReader reader(kMax);
  std::span<std::byte> chunk = all;
  EXPECT_EQ(reader.next(chunk).message.data(), all.data());
  EXPECT_TRUE(chunk.empty());
}

// After its header has arrived, a large message is read directly into its final buffer.
TEST(StreamReader, LargeMessageIsNotCopiedTwice) {
  const Bytes big = message(kMax, 7);
  StreamReader reader(kMax);
  EXPECT_TRUE(reader.room().empty()) << "no message has begun";
  std::vector<Bytes> out;
  EXPECT_EQ(feed(reader, std::span(big).first(1000), out), Status::kNeedMore);

  const std::span<std::byte> room = reader.room();
  ASSERT_EQ(room.size(), kMax - 1000);
  std::copy(big.begin() + 1000, big.end(), room.begin());
  reader.advance(room.size());
  std::span<std::byte> nothing;
  const StreamReader::Item item = reader.next(nothing);
  ASSERT_EQ(item.status, Status::kMessage);
  EXPECT_EQ(item.message.data() + 1000, room.data());
  EXPECT_TRUE(std::ranges::equal(item.message, big));
  EXPECT_EQ(reader.pending(), 0U);
}

TEST(StreamReader, NoRoomForASmallRest) {
  const Bytes big = message(100000, 7);
  StreamReader reader(kMax);
  std::vector<Bytes> out;
  feed(reader, std::span(big).first(99000), out);
  EXPECT_TRUE(reader.room().empty()) << "a chunk brings the next messages with the rest";
  feed(reader, std::span(big).subspan(99000), out);
  EXPECT_EQ(out, std::vector<Bytes>{big});
}

TEST(StreamReader, LengthsAtTheLimits) {
  constexpr std::uint32_t kSmallMax = 1000;
  for (const std::uint32_t length : {16U, 17U, kSmallMax - 1, kSmallMax}) {
    StreamReader reader(kSmallMax);
    std::vector<Bytes> out;
    EXPECT_EQ(feed(reader, message(length, 1), out), Status::kNeedMore);
    EXPECT_EQ(out.size(), 1U) << length;
  }
  for (const std::uint32_t length : {0U, 1U, 15U}) {
    StreamReader reader(kSmallMax);
    std::vector<Bytes> out;
    EXPECT_EQ(feed(reader, header_with_length(length), out), Status::kTooShort) << length;
  }
  for (const std::uint32_t length : {kSmallMax + 1, 0x10000000U, 0xFFFFFFFFU}) {
    StreamReader reader(kSmallMax);
    std::vector<Bytes> out;
    EXPECT_EQ(feed(reader, header_with_length(length), out), Status::kTooLong) << length;
  }
}

TEST(StreamReader, BadLengthIsSeenInASplitHeaderToo) {
  StreamReader reader(kMax);
  std::vector<Bytes> out;
  const Bytes bad = header_with_length(kMax + 1);
  EXPECT_EQ(feed(reader, std::span(bad).first(15), out), Status::kNeedMore);
  EXPECT_EQ(feed(reader, std::span(bad).subspan(15), out), Status::kTooLong);
  EXPECT_TRUE(reader.room().empty());
}

TEST(StreamReader, LostStreamStaysLost) {
  StreamReader reader(kMax);
  std::vector<Bytes> out;
  EXPECT_EQ(feed(reader, join({message(20, 1), header_with_length(3)}), out), Status::kTooShort);
  EXPECT_EQ(out.size(), 1U) << "what came before is delivered";
  Bytes good = message(20, 2);
  std::span<std::byte> chunk = good;
  const StreamReader::Item item = reader.next(chunk);
  EXPECT_EQ(item.status, Status::kTooShort);
  EXPECT_EQ(item.header.length, 3U) << "the refused length can still be reported";
  EXPECT_TRUE(item.message.empty());
}

// --- The client's end

Bytes bytes_of(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

Bytes unsent(const TcpClientProtocol& client) {
  return {client.unsent().begin(), client.unsent().end()};
}

// A message of the router itself: dest = src = 0.
Bytes router_message(std::int8_t type, std::uint8_t seq_nr, const Bytes& body = {}) {
  Bytes bytes(kHeaderSize);
  encode_header({.type = type,
                 .seq_nr = seq_nr,
                 .length = static_cast<std::uint32_t>(kHeaderSize + body.size())},
                HeaderBytes(bytes.data(), kHeaderSize));
  return join({bytes, body});
}

TEST(TcpClientProtocol, PutsMessagesInTheRequestedByteOrder) {
  TcpClientProtocol client(kMax);
  client.set_byte_order(std::endian::little);
  client.put_command(router_command::kMailboxInitWithReply, Address(0x00140001));
  EXPECT_EQ(unsent(client),
            bytes_of({3, 13, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 20, 0, 0, 0, 1, 0, 0x14, 0}));
  client.sent(20);
  client.set_byte_order(std::endian::big);
  client.put_command(router_command::kMailboxInit, Address(0x00140001));
  EXPECT_EQ(unsent(client),
            bytes_of({0, 11, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 20, 0, 0x14, 0, 1}));
}

TEST(TcpClientProtocol, WhatWasSentIsForgottenPieceByPiece) {
  TcpClientProtocol client(kMax);
  client.put({.type = 5, .dest = Address(1)}, message(17, 0));
  client.sent(30);
  EXPECT_EQ(client.unsent().size(), 3U);
  client.put_command(router_command::kDisableWatchdog);
  EXPECT_EQ(client.unsent().size(), 19U);
  client.sent(19);
  EXPECT_TRUE(client.unsent().empty());
}

TEST(TcpClientProtocol, LifesignsAreAnsweredAndNotShown) {
  TcpClientProtocol client(kMax);
  client.set_byte_order(std::endian::little);
  Bytes came = join({router_message(router_command::kLifesign, 9), message(20, 1)});
  std::span<std::byte> chunk = came;
  const StreamReader::Item item = client.next(chunk);
  ASSERT_EQ(item.status, Status::kMessage);
  EXPECT_EQ(item.header.dest, Address(1));
  EXPECT_EQ(client.lifesigns(), 1U);
  EXPECT_EQ(unsent(client), bytes_of({3, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 0, 16, 0, 0, 0}));
}

TEST(TcpClientProtocol, ARouterThatTakesNoAnswersGetsNoMoreOfThem) {
  TcpClientProtocol client(kMax);
  constexpr std::uint64_t kMany = 200'000;
  const Bytes lifesign = router_message(router_command::kLifesign, 0);
  while (client.lifesigns() < kMany) {
    Bytes came = lifesign;
    std::span<std::byte> chunk = came;
    ASSERT_EQ(client.next(chunk).status, Status::kNeedMore);
  }
  EXPECT_LE(client.unsent().size(), (1U << 20) + kHeaderSize);
}

TEST(TcpClientProtocol, LearnsHowTheFleetDividesAddresses) {
  TcpClientProtocol client(kMax);
  Bytes came = join({router_message(router_command::kAddressWidths, 0, bytes_of({6, 8, 10, 8})),
                     router_message(router_command::kAddressWidths, 0, bytes_of({1, 1, 1, 1})),
                     router_message(type::kOk, 0)});
  std::span<std::byte> chunk = came;
  const StreamReader::Item item = client.next(chunk);
  ASSERT_EQ(item.status, Status::kMessage);
  EXPECT_TRUE(is_router_message(item.header));
  EXPECT_EQ(item.header.type, type::kOk);
  EXPECT_EQ(client.widths(), (AddressWidths{6, 8, 10, 8})) << "no widths are not taken";
}

}  // namespace tcp_protocol_test

}  // namespace tims::wire
