// The example bytes in PROTOCOL.md equal the output of the code.
#include <cctype>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "base/text.h"
#include "router/link/datagram.h"
#include "router/link/frame.h"
#include "router/link/transport.h"

namespace tims::link {
namespace protocol_test {

// The document without spaces and line breaks.
std::string document() {
  std::ifstream file(TIMS_PROTOCOL_FILE);
  std::stringstream text;
  text << file.rdbuf();
  std::string squeezed;
  for (const char c : text.str()) {
    if (std::isspace(static_cast<unsigned char>(c)) == 0) squeezed += c;
  }
  return squeezed;
}

TEST(Protocol, TheHelloOfTheDocumentIsTheHelloOfTheCode) {
  const Hello hello{.token = 0x0102030405060708,
                    .keep_alive = std::chrono::milliseconds(300),
                    .identity = {.epoch = 0x1122334455667788,
                                 .role = Role::kSystem,
                                 .system = 1,
                                 .id = 1,
                                 .name = std::string_view("robot1"),
                                 .message_max = 16U << 20}};
  std::array<std::byte, kControlDatagramMax> bytes{};
  // Without the trailing zeros.
  auto encoded = std::span(bytes).first(encode(hello, bytes));
  EXPECT_EQ(encoded.size(), 256U);
  while (encoded.back() == std::byte{0}) encoded = encoded.first(encoded.size() - 1);
  EXPECT_NE(document().find(base::to_hex(encoded)), std::string::npos) << base::to_hex(encoded);
}

TEST(Protocol, TheDataOfTheDocumentIsTheDataOfTheCode) {
  std::array<std::byte, 64> bytes{};
  encode({.token = 0x1122334455667788, .packet = 5}, std::span(bytes).first<kDataHeaderSize>());
  ByteWriter out{std::span(bytes).subspan(kDataHeaderSize)};
  put_header(out, 7, 0, 2);
  out.put(std::uint8_t{0xAB});
  out.put(std::uint8_t{0xCD});
  const auto all = std::span(bytes).first(kDataHeaderSize + out.size());
  EXPECT_NE(document().find(base::to_hex(all)), std::string::npos) << base::to_hex(all);
}

TEST(Protocol, TheHandshakeOfTheDocumentIsTheHandshakeOfTheCode) {
  std::array<std::byte, kDatagramBase> bytes{};
  EXPECT_EQ(encode(SealedHello{0x0102030405060708}, bytes), kHelloSize);
  const auto hello = std::span(bytes).first(16);
  EXPECT_NE(document().find(base::to_hex(hello)), std::string::npos) << base::to_hex(hello);
  constexpr std::array kFirst{std::byte{0x16}, std::byte{0x03}};
  const Crypto crypto{.token = 0x0102030405060708, .cookie = 0x1112131415161718, .bytes = kFirst};
  const auto encoded = std::span(bytes).first(encode(crypto, bytes));
  EXPECT_NE(document().find(base::to_hex(encoded)), std::string::npos) << base::to_hex(encoded);
}

TEST(Protocol, TheListOfTheDocumentIsTheListOfTheCode) {
  const auto expect = [](std::int8_t type, const ListPlace& place,
                         std::span<const std::byte> bytes = {}) {
    ControlMessage message(type);
    message.put(place);
    message.put(bytes);
    const std::string hex = base::to_hex(message.finish());
    EXPECT_NE(document().find(hex), std::string::npos) << hex;
  };
  expect(control::kList, {7, 5000});
  expect(control::kListGet, {7, 4096});
  constexpr std::array kBytes{std::byte{0xAB}, std::byte{0xCD}};
  expect(control::kListPart, {7, 4096}, kBytes);
}

TEST(Protocol, TheAnnouncementOfTheDocumentIsTheAnnouncementOfTheCode) {
  const Announcement announcement{.fleet = std::string_view("harbour"),
                                  .identity = {.epoch = 0x1122334455667788,
                                               .role = Role::kSystem,
                                               .system = 1,
                                               .id = 1,
                                               .name = std::string_view("robot1"),
                                               .message_max = 16U << 20},
                                  .udp = {NetAddress::v4(10, 9, 1, 1, 2010)}};
  const auto bytes = encode(announcement);
  EXPECT_NE(document().find(base::to_hex(bytes)), std::string::npos) << base::to_hex(bytes);
}

TEST(Protocol, TheSampleOfTheDocumentIsTheSampleOfTheCode) {
  std::array<std::byte, 7> bytes{std::byte{2}, std::byte{0}, std::byte{0xAB}, std::byte{0xCD},
                                 std::byte{1}, std::byte{0}, std::byte{0xEF}};
  EXPECT_NE(document().find(base::to_hex(bytes)), std::string::npos) << base::to_hex(bytes);
  std::string read;
  ASSERT_TRUE(Batch(bytes).valid());
  Batch(bytes).for_each(
      [&](std::span<std::byte> datagram) { read += base::to_hex(datagram) + " "; });
  EXPECT_EQ(read, "abcd ef ");
}

}  // namespace protocol_test
}  // namespace tims::link
