#include "router/config/value.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tims::config {
namespace value_test {

using namespace std::chrono_literals;

constexpr Range kWide{std::numeric_limits<std::int64_t>::min(),
                      std::numeric_limits<std::int64_t>::max()};

// The value as TOML, or why it was refused.
std::string read(Kind kind, std::string_view text, Range range = kWide) {
  const auto value = parse_value(kind, range, text);
  return value ? to_toml(*value) : value.error().detail();
}

TEST(Value, DurationsCarryUnits) {
  EXPECT_EQ(std::get<Duration>(*parse_value(Kind::kDuration, kWide, "250ms")), 250ms);
  EXPECT_EQ(std::get<Duration>(*parse_value(Kind::kDuration, kWide, "5s")), 5s);
  EXPECT_EQ(std::get<Duration>(*parse_value(Kind::kDuration, kWide, "7us")), 7us);
  EXPECT_EQ(std::get<Duration>(*parse_value(Kind::kDuration, kWide, "7ns")), 7ns);
  EXPECT_EQ(std::get<Duration>(*parse_value(Kind::kDuration, kWide, "2min")), 2min);
  EXPECT_EQ(std::get<Duration>(*parse_value(Kind::kDuration, kWide, "1h")), 1h);
}

TEST(Value, SizesCarryUnits) {
  const auto bytes = [](std::string_view text) {
    return std::get<Bytes>(*parse_value(Kind::kSize, kWide, text)).count;
  };
  EXPECT_EQ(bytes("262144"), 262144);
  EXPECT_EQ(bytes("262144B"), 262144);
  EXPECT_EQ(bytes("4kB"), 4000);
  EXPECT_EQ(bytes("4MB"), 4'000'000);
  EXPECT_EQ(bytes("4GB"), 4'000'000'000);
  EXPECT_EQ(bytes("4KiB"), 4096);
  EXPECT_EQ(bytes("4MiB"), 4 << 20);
  EXPECT_EQ(bytes("4GiB"), 4LL << 30);
}

TEST(Value, PrintsTheLargestUnitThatSaysItExactly) {
  EXPECT_EQ(read(Kind::kSize, "4096KiB"), R"("4MiB")");
  EXPECT_EQ(read(Kind::kSize, "4MB"), R"("4000000B")");
  EXPECT_EQ(read(Kind::kSize, "0"), R"("0B")");
  EXPECT_EQ(read(Kind::kDuration, "60000ms"), R"("1min")");
  EXPECT_EQ(read(Kind::kDuration, "1500ms"), R"("1500ms")");
  EXPECT_EQ(read(Kind::kDuration, "0s"), R"("0ns")");
}

TEST(Value, UnknownUnitsAreNamed) {
  EXPECT_EQ(read(Kind::kSize, "4MIB"),
            R"(has the unknown unit "MIB" in "4MIB"; known are B, kB, MB, GB, KiB, MiB, GiB)");
  EXPECT_EQ(read(Kind::kDuration, "5sec"),
            R"(has the unknown unit "sec" in "5sec"; known are ns, us, ms, s, min, h)");
  EXPECT_EQ(read(Kind::kDuration, "1.5s"),
            R"(has the unknown unit ".5s" in "1.5s"; known are ns, us, ms, s, min, h)");
  EXPECT_EQ(read(Kind::kDuration, "5"),
            R"(must be a duration with its unit such as "250ms" or "5s", not "5")");
}

TEST(Value, WhatIsNoNumberIsRefused) {
  EXPECT_EQ(read(Kind::kSize, "much"),
            R"(must be a size such as "4MiB" or 262144 (bytes), not "much")");
  EXPECT_EQ(read(Kind::kSize, ""), R"(must be a size such as "4MiB" or 262144 (bytes), not "")");
  EXPECT_EQ(read(Kind::kNumber, "3x"), R"(must be a whole number, not "3x")");
  EXPECT_EQ(read(Kind::kNumber, " 3"), R"(must be a whole number, not " 3")");
}

TEST(Value, NumbersBeyond64BitsAreRefused) {
  EXPECT_EQ(read(Kind::kSize, "9223372036854775808"), R"("9223372036854775808" is too large)");
  EXPECT_EQ(read(Kind::kSize, "8589934592GiB"), R"("8589934592GiB" is too large)");
  EXPECT_EQ(read(Kind::kDuration, "9223372037s"), R"("9223372037s" is too large)");
}

TEST(Value, BothEndsOfARangeAreInIt) {
  constexpr Range kSizes{64 << 10, 1 << 30};
  EXPECT_EQ(read(Kind::kSize, "64KiB", kSizes), R"("64KiB")");
  EXPECT_EQ(read(Kind::kSize, "1GiB", kSizes), R"("1GiB")");
  EXPECT_EQ(read(Kind::kSize, "65535", kSizes), "65535B is out of range (64KiB to 1GiB)");
  EXPECT_EQ(read(Kind::kSize, "1073741825", kSizes), "1073741825B is out of range (64KiB to 1GiB)");
  EXPECT_EQ(read(Kind::kSize, "-1B", kSizes), "-1B is out of range (64KiB to 1GiB)");
  EXPECT_EQ(read(Kind::kNumber, "255", {0, 255}), "255");
  EXPECT_EQ(read(Kind::kNumber, "256", {0, 255}), "256 is out of range (0 to 255)");
  EXPECT_EQ(read(Kind::kNumber, "-1", {0, 255}), "-1 is out of range (0 to 255)");
  EXPECT_EQ(read(Kind::kText, "abc", {1, 3}), R"("abc")");
  EXPECT_EQ(read(Kind::kText, "abcd", {1, 3}), R"("abcd" is out of range (1 to 3 bytes long))");
  EXPECT_EQ(read(Kind::kText, "", {1, 3}), R"("" is out of range (1 to 3 bytes long))");
}

TEST(Value, FlagsAndLevelsAreNames) {
  EXPECT_EQ(read(Kind::kFlag, "true"), "true");
  EXPECT_EQ(read(Kind::kFlag, "false"), "false");
  EXPECT_EQ(read(Kind::kFlag, "yes"), R"(must be true or false, not "yes")");
  for (const std::string level : {"error", "warning", "info", "debug"})
    EXPECT_EQ(read(Kind::kLogLevel, level), in_quotes(level));
  EXPECT_EQ(read(Kind::kLogLevel, "warn"),
            R"(must be "error", "warning", "info" or "debug", not "warn")");
}

TEST(Value, EndpointsMayBeOff) {
  EXPECT_EQ(read(Kind::kEndpoint, "off"), R"("off")");
  EXPECT_EQ(read(Kind::kEndpoint, "localhost:2000"), R"("127.0.0.1:2000")");
  EXPECT_THAT(read(Kind::kEndpoint, "robot1:2000"), testing::HasSubstr("numeric address"));
}

TEST(Value, TextsAreQuotedForToml) {
  EXPECT_EQ(in_quotes(R"(a "b" \c)"), R"("a \"b\" \\c")");
  EXPECT_EQ(in_quotes("a\nb\x7f"), R"("a\u000Ab\u007F")");
  EXPECT_EQ(in_quotes("Süd"), "\"Süd\"");
  EXPECT_EQ(read(Kind::kText, "a$b"), R"("a$$b")");  // read back, it is the same text
  EXPECT_EQ(read(Kind::kText, "a\nb"), R"("a\u000Ab" holds a control character)");
}

TEST(Value, RatesAreSizesASecondOrNone) {
  constexpr Range kRates{10'000, 100'000'000'000};
  EXPECT_EQ(std::get<Rate>(*parse_value(Kind::kRate, kRates, "6MB")).bytes_per_second, 6'000'000);
  EXPECT_EQ(read(Kind::kRate, "6000kB", kRates), R"("6MB")");
  EXPECT_EQ(read(Kind::kRate, "1MiB", kRates), R"("1048576B")");
  EXPECT_EQ(read(Kind::kRate, "0", kRates), R"("0B")");
  EXPECT_EQ(read(Kind::kRate, "9999", kRates), "9999B is out of range (10kB to 100GB, or 0)");
  EXPECT_EQ(read(Kind::kRate, "-1", kRates), "-1B is out of range (10kB to 100GB, or 0)");
  EXPECT_EQ(read(Kind::kRate, "fast", kRates),
            R"(must be a rate such as "6MB" (bytes per second) or 0 for no limit, not "fast")");
}

TEST(Value, SystemsAreNumbersOrAny) {
  EXPECT_EQ(read(Kind::kSystem, "0"), "0");
  EXPECT_EQ(read(Kind::kSystem, "65535"), "65535");
  EXPECT_EQ(read(Kind::kSystem, "*"), R"("*")");
  EXPECT_EQ(read(Kind::kSystem, "65536"), "65536 is out of range (0 to 65535)");
  EXPECT_EQ(read(Kind::kSystem, "any"), R"(must be a system's number or "*" for any, not "any")");
}

TEST(Value, WidthsAddUpTo32) {
  EXPECT_EQ(read(Kind::kWidths, "8/8/8/8"), R"("8/8/8/8")");
  EXPECT_EQ(read(Kind::kWidths, "1/29/1/1"), R"("1/29/1/1")");
  for (const char* wrong : {"8/8/8/9", "0/16/8/8", "64/224/0/0"})
    EXPECT_THAT(read(Kind::kWidths, wrong), testing::HasSubstr("does not add up to 32 bits"));
  for (const char* wrong : {"", "8", "8/8/8", "8/8/8/8/0", "8/8/8/", "8/8/8/8 ", "-8/8/8/8",
                            "256/8/8/8", "a/8/8/8", "8,8,8,8"})
    EXPECT_THAT(read(Kind::kWidths, wrong), testing::StartsWith("must be four bit widths"));
}

TEST(Value, ClassesAscend) {
  EXPECT_EQ(read(Kind::kClasses, "0/1/15/25/35/45/100"), R"("0/1/15/25/35/45/100")");
  EXPECT_EQ(read(Kind::kClasses, "249/250/251/252/253/254/255"),
            R"("249/250/251/252/253/254/255")");
  for (const char* wrong : {"0/0/15/25/35/45/100", "0/1/15/25/35/45/44"})
    EXPECT_THAT(read(Kind::kClasses, wrong), testing::HasSubstr("does not ascend"));
  for (const char* wrong :
       {"", "1/2/3/4/5/6", "1/2/3/4/5/6/7/8", "1/2/3/4/5/6/256", "a/2/3/4/5/6/7"})
    EXPECT_THAT(read(Kind::kClasses, wrong), testing::StartsWith("must be seven priorities"));
}

TEST(Value, PathsAreAListWithoutDoubles) {
  EXPECT_EQ(read(Kind::kPaths, "udp"), R"(["udp"])");
  EXPECT_EQ(read(Kind::kPaths, "dds+udp"), R"(["dds", "udp"])");
  EXPECT_EQ(read(Kind::kPaths, "udp+tcp"), R"(["udp", "tcp"])");
  for (const char* wrong : {"", "UDP", "udp+", "+udp", "udp,dds", "udp+dds+ipx"})
    EXPECT_THAT(read(Kind::kPaths, wrong), testing::StartsWith("has the unknown path")) << wrong;
  EXPECT_EQ(read(Kind::kPaths, "dds+udp+dds"), R"(has "dds" twice)");
}

TEST(Value, RolesAndKindsAreNames) {
  for (const char* role : {"subsystem", "system", "top"})
    EXPECT_EQ(read(Kind::kRole, role), in_quotes(role));
  for (const char* kind : {"super", "peer", "sub"})
    EXPECT_EQ(read(Kind::kLinkKind, kind), in_quotes(kind));
  EXPECT_EQ(read(Kind::kRole, "Top"), R"(must be "subsystem", "system" or "top", not "Top")");
  EXPECT_EQ(range_text(Kind::kLinkKind, {}), "super, peer, sub");
}

}  // namespace value_test
}  // namespace tims::config
