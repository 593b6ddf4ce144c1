// The bodies of our extensions, byte for byte: programs of other versions must decode them.
#include "rack/proxies/generic.h"

#include <gtest/gtest.h>

#include "base/text.h"
#include "rack/codec/codec.h"
#include "rack/proxies/catalogue.h"

namespace rack {
namespace generic_test {

template <typename T>
std::string hex(const T& value, std::endian order) {
  std::vector<std::byte> body(encoded_size(value));
  EXPECT_TRUE(encode(value, body, order));
  return tims::base::to_hex(body);
}

RuntimeData runtime() {
  RuntimeData data{.since = 0x01020304,
                   .watch = 3,
                   .loops = 0x0506,
                   .blocked = 7,
                   .preempted = 8,
                   .pageFaults = 9,
                   .lost = 10};
  data.places.push_back({.kind = RuntimePlace::kPageFault, .count = 11, .where = "look"});
  return data;
}

TEST(Generic, RuntimeOnTheWire) {
  const std::string zeros(2 * 196, '0');
  EXPECT_EQ(hex(runtime(), std::endian::big),
            "0102030400000003000000000000050600000000000000070000000000000008"
            "0000000000000009000000000000000a00000001"
            "00000001000000000000000b6c6f6f6b" +
                zeros);
  EXPECT_EQ(hex(runtime(), std::endian::little),
            "0403020103000000060500000000000007000000000000000800000000000000"
            "09000000000000000a0000000000000001000000"
            "010000000b000000000000006c6f6f6b" +
                zeros);
}

TEST(Generic, ListenersOnTheWire) {
  const ListenersData data{
      .periodTime = 20,
      .dataSets = 300,
      .listeners = {{.mailbox = tims::Address(0x00180002), .periodTime = 40, .priority = 5}}};
  EXPECT_EQ(hex(data, std::endian::big),
            "00000014000000000000012c00000001"
            "001800020000002800000005");
}

TEST(Generic, ParameterEffectsOnTheWire) {
  ParameterEffects effects;
  effects.effects.push_back({.name = "vxMax", .takesEffect = static_cast<i32>(TakesEffect::kAtOn)});
  EXPECT_EQ(hex(effects, std::endian::big),
            "0000000176784d6178" + std::string(2 * 75, '0') + "00000001");
}

TEST(Generic, RuntimeIsKnownOfEveryClass) {
  const MessageInfo* known = find_message(0x11, tims::type::kRuntime);
  ASSERT_NE(known, nullptr);
  EXPECT_EQ(known->name, "RUNTIME");
  EXPECT_EQ(find_message(0x14, tims::type::kGetListeners)->name, "GET_LISTENERS");
}

}  // namespace generic_test
}  // namespace rack
