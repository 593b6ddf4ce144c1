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

TEST(Generic, DescriptionOnTheWire) {
  EXPECT_EQ(hex(DescriptionRequest{.offset = 258, .bytesMax = 3}, std::endian::little),
            "0201000003000000");
  DescriptionPage page{.size = 7, .offset = 5};
  page.text = {'o', 'k'};
  EXPECT_EQ(hex(page, std::endian::big), "0000000700000005000000026f6b");
  EXPECT_EQ(find_message(0x14, tims::type::kGetDescription)->name, "GET_DESCRIPTION");
  EXPECT_EQ(find_message(0x14, tims::type::kDescription)->name, "DESCRIPTION");
}

// Reads a description as Proxy::describe() does.
std::string read_in_pages(std::string_view description, i32 bytes_max) {
  std::string text;
  for (bool more = true; more;) {
    const auto page =
        page_of(description, {.offset = static_cast<i32>(text.size()), .bytesMax = bytes_max});
    EXPECT_TRUE(page);
    const auto appended = append_page(text, *page);
    EXPECT_TRUE(appended) << appended.error().message();
    more = appended && *appended;
  }
  return text;
}

TEST(Generic, DescriptionsOfAnyLengthComeInPages) {
  for (const std::size_t size : {0U, 1U, 3999U, 4000U, 4001U, 8000U, 20001U}) {
    const std::string text(size, 'x');
    EXPECT_EQ(read_in_pages(text, 0), text);
    EXPECT_EQ(read_in_pages(text, 70), text);
    EXPECT_EQ(read_in_pages(text, 5000), text);
  }
}

TEST(Generic, PagesOutsideOfTheDescriptionAreRefused) {
  EXPECT_TRUE(page_of("abc", {.offset = 3}));
  for (const DescriptionRequest request :
       {DescriptionRequest{.offset = 4}, {.offset = -1}, {.offset = 0, .bytesMax = -1}}) {
    const auto page = page_of("abc", request);
    ASSERT_FALSE(page);
    EXPECT_TRUE(page.error().detail().starts_with("the description has 3 bytes, requested are"));
  }
}

TEST(Generic, PagesThatDoNotFitAreRefused) {
  const auto refused = [](DescriptionPage page, std::string_view text) {
    page.text.assign(text.begin(), text.end());
    std::string description = "ab";
    return !append_page(description, page) && description == "ab";
  };
  EXPECT_FALSE(refused({.size = 3, .offset = 2}, "c"));
  EXPECT_TRUE(refused({.size = 3, .offset = 1}, "c"));
  EXPECT_TRUE(refused({.size = 3, .offset = -2}, "c"));
  EXPECT_TRUE(refused({.size = 3, .offset = 2}, "cd"));
  EXPECT_TRUE(refused({.size = 3, .offset = 2}, ""));
  EXPECT_TRUE(refused({.size = -1, .offset = 2}, "c"));
  EXPECT_FALSE(refused({.size = 1 << 20, .offset = 2}, "c"));
  EXPECT_TRUE(refused({.size = (1 << 20) + 1, .offset = 2}, "c"));
}

}  // namespace generic_test
}  // namespace rack
