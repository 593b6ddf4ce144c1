#include "components/devices/positioning/binary_protocols.h"

#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text.h"

namespace rack::device {
namespace binary_protocols_test {

std::string found_after(std::string_view hex, int times) {
  const auto packet = *tims::base::parse_hex(hex);
  BinaryProtocols protocols;
  for (int i = 0; i < times; ++i)
    for (const std::byte byte : packet) protocols.add(std::span(&byte, 1));
  return std::string(protocols.found());
}

TEST(BinaryProtocolsTest, EachIsNamedWithWhatToDo) {
  for (const auto& [packet, text] :
       {std::pair{"B562 0107 0000 0819", "GpsUblox"}, std::pair{"A0A2 0001 29 0029 B0B3", "SiRF"},
        std::pair{"10 8F20 01 1003", "Trimble"}, std::pair{"AA4412 1C 0000", "NovAtel"},
        std::pair{"2440 1234 5678", "Septentrio"}}) {
    EXPECT_THAT(found_after(packet, 3), testing::HasSubstr(text));
    EXPECT_EQ(found_after(packet, 1), "") << "once may be chance";
  }
}

TEST(BinaryProtocolsTest, TextAndZerosAreNone) {
  EXPECT_EQ(found_after("24 4750524D43 2C 0D0A", 1000), "");
  EXPECT_EQ(found_after("00", 1000), "");
  EXPECT_EQ(found_after("A0A2 A0A2", 1000), "") << "the ends are missing";
}

// As received at a wrong rate during five seconds at 4800 baud.
TEST(BinaryProtocolsTest, NoiseIsMostlyNone) {
  std::mt19937 random(1);
  int named = 0;
  for (int run = 0; run < 200; ++run) {
    BinaryProtocols protocols;
    for (int i = 0; i < 2400; ++i) {
      const auto byte = static_cast<std::byte>(random());
      protocols.add(std::span(&byte, 1));
    }
    named += protocols.found().empty() ? 0 : 1;
  }
  EXPECT_LT(named, 3);
}

}  // namespace binary_protocols_test
}  // namespace rack::device
