#include "tools/cli/output.h"

#include <boost/json/parse.hpp>
#include <gtest/gtest.h>

#include "base/measure.h"
#include "base/text.h"

namespace timsctl {
namespace output_test {

constexpr Column kColumns[] = {
    {"NAME", "name"},
    {"SIZE", "size_bytes", Cell::kBytes},
    {"AGE", "age_s", Cell::kDuration, true},
    {"DROPS", "drops", Cell::kCount, false, true},
};

json::array items() {
  return json::parse(R"([
    {"name": "a", "size_bytes": 2048, "age_s": 61, "drops": 0},
    {"name": "längster", "size_bytes": 1, "age_s": 0.002, "drops": 7},
    {"name": null, "drops": 12345678}
  ])")
      .as_array();
}

std::string rendered(Format format, bool colour = false) {
  const json::array all = items();
  return render_items(all, kColumns, {.format = format, .colour = colour});
}

TEST(Render, ColumnsAreAligned) {
  EXPECT_EQ(rendered(Format::kTable),
            "NAME         SIZE  DROPS\n"
            "a         2.0 KiB      0\n"
            "längster      1 B      7\n"
            "-               -  12.3M\n");
}

TEST(Render, WideShowsMore) {
  EXPECT_NE(rendered(Format::kWide).find("1m 1s"), std::string::npos);
  EXPECT_EQ(rendered(Format::kTable).find("1m 1s"), std::string::npos);
}

TEST(Render, PlainHasNoHeaderAndNamesOnlyNames) {
  EXPECT_EQ(rendered(Format::kPlain).find("NAME"), std::string::npos);
  EXPECT_EQ(rendered(Format::kName), "a\nlängster\n-\n");
}

TEST(Render, CsvHasRawValues) {
  EXPECT_EQ(rendered(Format::kCsv),
            "name,size_bytes,age_s,drops\n"
            "a,2048,61,0\n"
            "längster,1,2E-3,7\n"
            ",,,12345678\n");
  const json::array odd = json::parse(R"([{"name": "x,\"y\""}])").as_array();
  EXPECT_EQ(render_items({odd.data(), 1}, std::span(kColumns).first(1), {.format = Format::kCsv}),
            "name\n\"x,\"\"y\"\"\"\n");
}

TEST(Render, AlarmsAreRedOnlyWithColour) {
  EXPECT_NE(rendered(Format::kTable, true).find("\033[31m    7\033[0m"), std::string::npos);
  EXPECT_EQ(rendered(Format::kTable).find('\033'), std::string::npos);
}

TEST(Render, NamesCannotMoveTheCursor) {
  const json::array evil = json::parse(R"([{"name": "a\u001b[2Jb\u009b\n"}])").as_array();
  EXPECT_EQ(render_items({evil.data(), 1}, std::span(kColumns).first(1), {}), "NAME\na?[2Jb??\n");
}

TEST(Render, PageHasALineAField) {
  EXPECT_EQ(render_page(items()[0].as_object(), kColumns, {}),
            "NAME:   a\nSIZE:   2.0 KiB\nDROPS:  0\n");
}

TEST(Render, SortsNumbersDownAndTextsUp) {
  json::array all = items();
  sort_items(all, kColumns, "drops");
  EXPECT_EQ(number_at(all[0].as_object(), "drops"), 12345678);
  sort_items(all, kColumns, "NAME");
  EXPECT_EQ(text_at(all[2].as_object(), "name"), "längster");
  EXPECT_THROW(sort_items(all, kColumns, "weight"), Failure);
}

TEST(Humanize, Numbers) {
  EXPECT_EQ(base::human_count(812), "812");
  EXPECT_EQ(base::human_count(99'999), "99999");
  EXPECT_EQ(base::human_count(123'456), "123.5k");
  EXPECT_EQ(base::human_bytes(512), "512 B");
  EXPECT_EQ(base::human_bytes(1536), "1.5 KiB");
  EXPECT_EQ(base::human_duration(0), "0s");
  EXPECT_EQ(base::human_duration(0.0000142), "14.2us");
  EXPECT_EQ(base::human_duration(0.0031), "3.10ms");
  EXPECT_EQ(base::human_duration(130), "2m 10s");
  EXPECT_EQ(base::human_duration(7265), "2h 1m");
  EXPECT_EQ(base::human_duration(3 * 86400 + 4 * 3600), "3d 4h");
  EXPECT_EQ(base::human_duration(-2), "-2.00s");
  EXPECT_EQ(base::human_rate(0.2), "0.20");
  EXPECT_EQ(base::human_rate(75), "75.0");
}

TEST(Humanize, Times) {
  const base::WallTime time(std::chrono::nanoseconds(1'800'000'000'123'456'789));
  EXPECT_EQ(base::rfc3339(time), "2027-01-15T08:00:00.123456Z");
  EXPECT_EQ(time_of_day(time, true), "08:00:00.123Z");
  EXPECT_EQ(base::rfc3339(*base::parse_rfc3339("2027-01-15T08:00:00.123456Z")),
            base::rfc3339(time));
  EXPECT_EQ(local_time("yesterday", true), "yesterday");
}

TEST(Json, PathsThatAreNotThere) {
  const json::object object = json::parse(R"({"a": {"b": 3, "n": null}, "t": "x"})").as_object();
  EXPECT_EQ(number_at(object, "a.b"), 3);
  EXPECT_FALSE(number_at(object, "a.c"));
  EXPECT_FALSE(number_at(object, "t.b"));
  EXPECT_EQ(at_path(object, "a.n"), nullptr);
  EXPECT_EQ(text_at(object, "t"), "x");
  EXPECT_TRUE(items_of(object).empty());
}

}  // namespace output_test
}  // namespace timsctl
