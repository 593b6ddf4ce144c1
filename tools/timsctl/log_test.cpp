#include "tools/timsctl/log.h"

#include <gtest/gtest.h>

#include "tools/cli/failure.h"

namespace timsctl {
namespace log_test {

using namespace std::chrono_literals;
using rack::gdos::Level;
using rack::gdos::Record;
using rack::gdos::RecordTime;

constexpr RecordTime kNow{1763780400123ms};  // 2025-11-22 03:00:00.123 UTC

std::string when(std::string_view text) {
  const auto time = parse_when(text, kNow, true);
  return time ? rack::gdos::to_text(*time) : "none";
}

TEST(When, AgoAndByTheClock) {
  EXPECT_EQ(when("10min"), "2025-11-22T02:50:00.123Z");
  EXPECT_EQ(when("1h"), "2025-11-22T02:00:00.123Z");
  EXPECT_EQ(when("02:15"), "2025-11-22T02:15:00.000Z");
  EXPECT_EQ(when("02:15:30"), "2025-11-22T02:15:30.000Z");
  EXPECT_EQ(when("2025-11-21"), "2025-11-21T00:00:00.000Z");
  EXPECT_EQ(when("2025-11-21 23:15"), "2025-11-21T23:15:00.000Z");
  EXPECT_EQ(when("2025-11-21T23:15:30"), "2025-11-21T23:15:30.000Z");
  EXPECT_EQ(when("2025-11-21T23:15:30.5Z"), "2025-11-21T23:15:30.500Z");
  for (const char* none : {"", "yesterday", "25:00", "02:15x", "2025-13-01", "2025-11-21T"})
    EXPECT_EQ(when(none), "none") << none;
}

TEST(When, LocalTimeUnlessItSaysOtherwise) {
  ::setenv("TZ", "EET-2", 1);  // two hours before UTC
  ::tzset();
  const auto local = parse_when("2025-11-22 02:00", kNow, false);
  const auto zulu = parse_when("2025-11-22 02:00Z", kNow, false);
  ::unsetenv("TZ");
  ::tzset();
  ASSERT_TRUE(local && zulu);
  EXPECT_EQ(rack::gdos::to_text(*local), "2025-11-22T00:00:00.000Z");
  EXPECT_EQ(rack::gdos::to_text(*zulu), "2025-11-22T02:00:00.000Z");
}

TEST(TextFilter, ComponentLevelAndTime) {
  Options options;
  options.utc = true;
  options.component = "Chassis/*/0";
  options.level = Level::kWarning;
  options.since = "10min";
  options.until = "03:00:00";
  const TextFilter filter = text_filter(options, kNow);
  const Record good{.time = kNow - 1s, .component = "Chassis(3/0)", .level = Level::kError};
  EXPECT_TRUE(filter.passes(good));
  const auto without = [&](auto change) {
    Record record = good;
    change(record);
    return filter.passes(record);
  };
  EXPECT_TRUE(without([](Record& r) { r.level = Level::kPrint; })) << "more important than all";
  EXPECT_TRUE(without([](Record& r) { r.component = "Chassis(3/0):2"; })) << "its proxies";
  EXPECT_FALSE(without([](Record& r) { r.level = Level::kInfo; }));
  EXPECT_FALSE(without([](Record& r) { r.component = "Ladar(3/0)"; }));
  EXPECT_FALSE(without([](Record& r) { r.component = "Chassis(3/1)"; }));
  EXPECT_FALSE(without([](Record& r) { r.time = kNow; }));
  EXPECT_FALSE(without([](Record& r) { r.time = kNow - 11min; }));
}

// The files of texts do not contain the widths of the fleet's addresses.
TEST(TextFilter, SendersAreComparedByName) {
  const auto passes = [](const std::string& pattern, const char* sender, std::uint32_t raw = 0) {
    Options options;
    options.component = pattern;
    return text_filter(options, kNow)
        .passes({.time = kNow, .address = tims::Address(raw), .component = sender});
  };
  EXPECT_TRUE(passes("Chassis(3/500)", "Chassis(3/500)"));
  EXPECT_TRUE(passes("chassis/1000/*", "Chassis(1000/63)"));
  EXPECT_FALSE(passes("Chassis(3/500)", "Chassis(3/50)"));
  EXPECT_TRUE(passes("Chassis", "Chassis(1000/63):4"));
  EXPECT_TRUE(passes("*", "whatever"));
  EXPECT_TRUE(passes("*(3/0)", "Pilot(3/0):1"));
  EXPECT_FALSE(passes("*(3/0):2", "Pilot(3/0):1"));
  EXPECT_FALSE(passes("*(3/0):2", "Pilot(3/0)"));
  EXPECT_TRUE(passes("unknown[90]", "unknown[90](0/0)"));
  EXPECT_TRUE(passes("0x03110000", "Chassis(3/0)", 0x03110000));
  EXPECT_FALSE(passes("0x03110000", "Chassis(3/0)", 0x03110100));
}

TEST(TextFilter, RefusesWhatItDoesNotUnderstand) {
  Options options;
  options.since = "soon";
  EXPECT_THROW(text_filter(options, kNow), Failure);
  options.since.clear();
  options.component = "Nobody";
  EXPECT_THROW(text_filter(options, kNow), Failure);
}

}  // namespace log_test
}  // namespace timsctl
