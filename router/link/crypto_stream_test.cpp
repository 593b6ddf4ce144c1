#include "router/link/crypto_stream.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace crypto_stream_test {

using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

struct Piece {
  std::uint32_t offset;
  std::uint32_t acknowledged;
  Bytes bytes;
};

std::vector<Piece> flush(CryptoStream& stream, Time now) {
  std::vector<Piece> pieces;
  stream.flush(now, {.token = 512}, [&](const Crypto& crypto) {
    pieces.push_back(
        {crypto.offset, crypto.acknowledged, {crypto.bytes.begin(), crypto.bytes.end()}});
  });
  return pieces;
}

Bytes receive(CryptoStream& stream, const Piece& piece, bool good = true) {
  std::span<const std::byte> bytes;
  EXPECT_EQ(stream.receive(
                {.offset = piece.offset, .acknowledged = piece.acknowledged, .bytes = piece.bytes},
                bytes),
            good);
  return {bytes.begin(), bytes.end()};
}

Bytes flight(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 7);
  return bytes;
}

TEST(CryptoStream, CarriesAFlightInPieces) {
  const Time now{100s};
  CryptoStream from;
  CryptoStream to;
  const Bytes all = flight(3000);
  ASSERT_TRUE(from.write(all));
  Bytes got;
  for (const Piece& piece : flush(from, now)) {
    EXPECT_LE(piece.bytes.size() + kCryptoHeaderSize, kDatagramBase);
    const Bytes bytes = receive(to, piece);
    got.insert(got.end(), bytes.begin(), bytes.end());
    for (const Piece& answer : flush(to, now)) receive(from, answer);
  }
  EXPECT_EQ(got, all);
  EXPECT_TRUE(from.is_acknowledged());
  EXPECT_EQ(from.next_timeout(), kNever);
  EXPECT_TRUE(flush(from, now).empty());
}

TEST(CryptoStream, RepeatsWhatIsNotAcknowledgedMoreAndMoreSeldom) {
  Time now{100s};
  CryptoStream from;
  ASSERT_TRUE(from.write(flight(100)));
  EXPECT_EQ(flush(from, now).size(), 1U);
  Duration before{};
  for (int i = 0; i < 8; ++i) {
    const Duration wait = from.next_timeout() - now;
    EXPECT_GE(wait, before);
    EXPECT_LE(wait, 3 * CryptoStream::kRepeatMax / 2);
    before = wait;
    EXPECT_TRUE(flush(from, now).empty());
    now = from.next_timeout();
    EXPECT_EQ(flush(from, now).size(), 1U);
  }
}

TEST(CryptoStream, GapsAndOverlapsGiveEachByteOnce) {
  CryptoStream to;
  const Bytes all = flight(100);
  const auto part = [&](std::uint32_t from, std::size_t size) {
    return Piece{from, 0, {all.begin() + from, all.begin() + from + static_cast<int>(size)}};
  };
  EXPECT_TRUE(receive(to, part(50, 50)).empty()) << "too early: it comes again";
  EXPECT_EQ(receive(to, part(0, 30)).size(), 30U);
  EXPECT_TRUE(receive(to, part(10, 20)).empty());
  const Bytes rest = receive(to, part(20, 40));
  EXPECT_EQ(rest, Bytes(all.begin() + 30, all.begin() + 60));
  EXPECT_EQ(flush(to, Time{1s}).front().acknowledged, 60U);
}

TEST(CryptoStream, HasALimit) {
  CryptoStream stream;
  EXPECT_TRUE(stream.write(flight(CryptoStream::kBytesMax)));
  EXPECT_FALSE(stream.write(flight(1)));
  receive(stream, {CryptoStream::kBytesMax - 1, 0, flight(1)});
  receive(stream, {CryptoStream::kBytesMax, 0, flight(1)}, false);
  receive(stream, {0xFFFFFFFF, 0, flight(1)}, false);
  receive(stream, {0, CryptoStream::kBytesMax + 1, {}}, false);
}

}  // namespace crypto_stream_test
}  // namespace tims::link
