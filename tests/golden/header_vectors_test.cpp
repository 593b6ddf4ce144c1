// Headers written by original programs are decoded, encoded again, and extracted from a stream.
#include <algorithm>
#include <array>
#include <bit>

#include <gtest/gtest.h>

#include "base/text.h"
#include "tests/support/golden_vectors.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace header_vectors_test {

using wire::StreamReader;

constexpr std::uint32_t kLengthMax = 262144;  // limit of the original router
constexpr std::string_view kCorrupt = "V90";

std::vector<GoldenVector> all_vectors() {
  auto vectors = read_golden_vectors();
  EXPECT_TRUE(vectors) << vectors.error().message();
  return vectors ? *std::move(vectors) : std::vector<GoldenVector>();
}

std::vector<GoldenVector> sound_vectors() {
  std::vector<GoldenVector> vectors = all_vectors();
  std::erase_if(vectors, [](const GoldenVector& v) { return v.name == kCorrupt; });
  return vectors;
}

wire::ConstHeaderBytes header_bytes(const GoldenVector& v) {
  return wire::ConstHeaderBytes(v.bytes.data(), kHeaderSize);
}

std::string label(const GoldenVector& v) { return v.name + " " + v.origin; }

std::string encoded(const Header& header, std::endian order) {
  std::array<std::byte, kHeaderSize> bytes{};
  wire::encode_header(header, bytes, order);
  return base::to_hex(bytes);
}

TEST(GoldenHeaders, AllAreThere) { EXPECT_EQ(all_vectors().size(), 104U); }

TEST(GoldenHeaders, DecodeToWhatTheSpecificationStates) {
  for (const GoldenVector& v : all_vectors()) {
    EXPECT_EQ(wire::decode_header(header_bytes(v)), v.stated) << label(v);
  }
}

TEST(GoldenHeaders, LengthMatchesTheBytes) {
  for (const GoldenVector& v : sound_vectors()) {
    EXPECT_EQ(v.stated.length, v.bytes.size()) << label(v);
  }
}

TEST(GoldenHeaders, EncodeByteForByte) {
  for (const GoldenVector& v : all_vectors()) {
    const bool little = (v.stated.flags & flag::kHeaderLittleEndian) != 0;
    EXPECT_EQ(encoded(v.stated, little ? std::endian::little : std::endian::big),
              base::to_hex(header_bytes(v)))
        << label(v);
  }
}

// As for a peer with the other byte order: the meaning is the same, only bit 0 of the flags
// differs.
TEST(GoldenHeaders, EncodeInTheOtherOrderMeansTheSame) {
  for (const GoldenVector& v : sound_vectors()) {
    const bool little = (v.stated.flags & flag::kHeaderLittleEndian) != 0;
    std::array<std::byte, kHeaderSize> bytes{};
    wire::encode_header(v.stated, bytes, little ? std::endian::big : std::endian::little);
    Header again = wire::decode_header(bytes);
    EXPECT_EQ(again.flags, v.stated.flags ^ flag::kHeaderLittleEndian) << label(v);
    again.flags = v.stated.flags;
    EXPECT_EQ(again, v.stated) << label(v);
    EXPECT_EQ(bytes[4], v.bytes[7]) << label(v);
    EXPECT_EQ(bytes[12], v.bytes[15]) << label(v);
  }
}

// C and Java messages for the same purpose differ only in flags, priority and sequence number, so
// the bytes of one can be produced from the header of the other.
TEST(GoldenHeaders, CAndJavaPairsMeanTheSame) {
  const std::vector<GoldenVector> vectors = sound_vectors();
  int pairs = 0;
  for (std::size_t i = 1; i < vectors.size(); ++i) {
    const GoldenVector& c = vectors[i - 1];
    const GoldenVector& java = vectors[i];
    if (c.name != java.name) continue;
    ++pairs;
    Header header = wire::decode_header(header_bytes(c));
    header.flags = 0;
    header.priority = java.stated.priority;
    header.seq_nr = java.stated.seq_nr;
    EXPECT_EQ(encoded(header, std::endian::big), base::to_hex(header_bytes(java))) << label(java);
  }
  EXPECT_EQ(pairs, 31);
}

TEST(GoldenHeaders, OneStreamOfAllOfThem) {
  const std::vector<GoldenVector> vectors = sound_vectors();
  std::vector<std::byte> all;
  for (const GoldenVector& v : vectors) all.insert(all.end(), v.bytes.begin(), v.bytes.end());
  StreamReader reader(kLengthMax);
  std::span<std::byte> chunk = all;
  for (const GoldenVector& v : vectors) {
    const StreamReader::Item item = reader.next(chunk);
    ASSERT_EQ(item.status, StreamReader::Status::kMessage) << label(v);
    EXPECT_EQ(item.header, v.stated) << label(v);
    EXPECT_TRUE(std::ranges::equal(item.message, v.bytes)) << label(v);
  }
  EXPECT_EQ(reader.next(chunk).status, StreamReader::Status::kNeedMore);
}

// The specification requires that this corrupt header is neither produced nor accepted.
TEST(GoldenHeaders, CorruptOneIsRefused) {
  for (GoldenVector& v : all_vectors()) {
    if (v.name != kCorrupt) continue;
    StreamReader reader(kLengthMax);
    std::span<std::byte> chunk = v.bytes;
    const StreamReader::Item item = reader.next(chunk);
    EXPECT_EQ(item.status, StreamReader::Status::kTooLong);
    EXPECT_EQ(item.header.length, 0x14000000U);
  }
}

TEST(GoldenHeaders, AnIncompleteMessageIsNotReturned) {
  for (GoldenVector& v : sound_vectors()) {
    for (std::size_t cut = 0; cut < v.bytes.size(); ++cut) {
      StreamReader reader(kLengthMax);
      std::span<std::byte> chunk = std::span(v.bytes).first(cut);
      ASSERT_EQ(reader.next(chunk).status, StreamReader::Status::kNeedMore)
          << label(v) << " cut to " << cut << " bytes";
    }
  }
}

}  // namespace header_vectors_test
}  // namespace tims::test
