#include "components/runtime/log_text.h"

#include <string>

#include <gtest/gtest.h>

#include "rack/address_text.h"
#include "rack/text_log.h"
#include "tests/support/counted_new.h"

namespace rack {
namespace log_text_test {

// The body of the message, without its NUL.
template <typename... Args>
std::string body(fmt::string_view format, const Args&... args) {
  gdos::Body body{};
  const std::size_t size = log_text(body, format, fmt::make_format_args(args...));
  EXPECT_EQ(body.at(size - 1), std::byte{0});
  return {reinterpret_cast<const char*>(body.data()), size - 1};
}

AddressText address_text(std::uint32_t raw, tims::AddressWidths widths = {}) {
  return {tims::Address(raw), widths};
}

TEST(LogText, IsFormattedBeforeItIsSent) {
  EXPECT_EQ(body("ready"), "ready");
  EXPECT_EQ(body("{} of {}: {}, {:.2f}", 3, std::size_t{1} << 40, std::string("x"), 1.234),
            "3 of 1099511627776: x, 1.23");
  EXPECT_EQ(body("{{}} {}", "{}"), "{} {}");
}

TEST(LogText, APercentSignIsNoConversion) {
  EXPECT_EQ(body("{}% of {}", 100, "%zu"), "100%% of %%zu");
}

TEST(LogText, AddressesAreNamesOfTheirFleet) {
  EXPECT_EQ(body("{} is gone", address_text(0x03140002)), "Ladar(3/0):2 is gone");
  constexpr tims::AddressWidths kWide{.system = 6, .class_id = 6, .instance = 12, .local = 8};
  const auto pilot = tims::Address::of({.system = 1, .class_id = 0x18, .instance = 700}, kWide);
  EXPECT_EQ(body("{}", address_text(pilot.raw(), kWide)), "Pilot(1/700)");
  EXPECT_EQ(body("|{:>12}|{:<12}|", address_text(0x00180100), address_text(0x00180100)),
            "|  Pilot(0/1)|Pilot(0/1)  |");
}

TEST(LogText, IsCutBetweenCharacters) {
  const std::string long_text(300, 'x');
  EXPECT_EQ(body("{}", long_text), long_text.substr(0, 255));
  // Of each length from one to four bytes, at each place around the end of the body.
  for (const std::string character : {"x", "\u00e4", "\u20ac", "\U0001F916"}) {
    for (std::size_t before = 248; before < 260; ++before) {
      const std::string text = long_text.substr(0, before) + character;
      const std::string expected =
          text.size() <= 255 ? text : text.substr(0, std::min<std::size_t>(before, 255));
      EXPECT_EQ(body("{}{}", text, long_text).substr(0, expected.size()), expected);
      EXPECT_EQ(body("{}", text), expected) << before;
    }
  }
}

TEST(LogText, WrongArgumentsStopNobody) {
  EXPECT_EQ(body("{:{}} left", 1, -1), "{:{}} left");
  EXPECT_EQ(body("{} of {}", 1), "{} of {}");
  EXPECT_EQ(body("{:d}", "text"), "{:d}");
}

TEST(LogText, AllocatesNothing) {
  const std::string long_text(300, 'x');
  const auto server = address_text(0x03200702);
  gdos::Body body{};
  const std::size_t before = tims::test::allocations();
  for (int i = 0; i < 100; ++i)
    (void)log_text(body, "{} {} {:.3f} {:>30} {}",
                   fmt::make_format_args(i, server, 1e300, "text", long_text));
  EXPECT_EQ(tims::test::allocations(), before);
}

template <typename... Args>
concept Checked = requires(TextLog& log, const Args&... args) { log.warning("{}", args...); };

// What a log takes; formats that are wrong are errors of the compiler and cannot be tested here.
static_assert(Checked<tims::Address> && Checked<std::string> && Checked<const char*>);
static_assert(Checked<std::size_t> && Checked<float> && Checked<bool> && Checked<std::string_view>);

TEST(TextLog, OfAnyArgumentsIsPutIntoTheRingWithoutAllocating) {
  TextLog log(gdos::Level::kWarning);
  log.set_widths({.system = 6, .class_id = 6, .instance = 12, .local = 8});
  const std::size_t before = tims::test::allocations();
  for (int i = 0; i < 100; ++i)  // more than the ring has
    log.warning("{} of {}: {}", i, tims::Address(0x03200702), "text");
  log.detail("{}", "below the threshold");
  EXPECT_EQ(tims::test::allocations(), before);
}

}  // namespace log_text_test
}  // namespace rack
