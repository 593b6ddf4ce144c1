// JSON, read without asking at every step whether it is there; what a person sees of it (tables,
// pages, CSV, names: pure); and where a command writes: results to stdout, remarks to stderr.
#pragma once

#include <functional>
#include <optional>
#include <ranges>
#include <span>
#include <string>
#include <string_view>

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>

#include "base/measure.h"
#include "tools/cli/failure.h"
#include "tools/cli/options.h"

namespace timsctl {

namespace json = boost::json;

// "owner.name": the member of the member; nullptr when it is not there or null.
const json::value* at_path(const json::object& object, std::string_view path);
std::optional<double> number_at(const json::object& object, std::string_view path);
double number_or_zero(const json::object& object, std::string_view path);
// Texts as they are, other values as JSON; empty when not there.
std::string text_at(const json::object& object, std::string_view path);
// What is in the list, nothing when it is missing; most are called "items".
std::span<const json::value> items_of(const json::object& answer, std::string_view list = "items");
std::span<const json::value> items_of(json::object&& gone,
                                      std::string_view list = "items") = delete;
json::array& item_array(json::object& answer);  // made when it is missing
inline auto objects(std::span<const json::value> items) {
  return std::views::transform(
      items, [](const json::value& item) -> const json::object& { return item.as_object(); });
}
void objects(json::array&& gone) = delete;

std::string to_text(const json::value& value);  // compact, one line

// From JSON items to text: aligned tables, plain rows, CSV, names. Pure.

// How output is to look.
struct Look {
  Format format = Format::kTable;
  bool colour = false;
  bool utc = false;
  std::string sort{};  // a column's title or path, without regard to case

  // Text to be read, and not rows that are all alike.
  [[nodiscard]] bool for_people() const {
    return format == Format::kTable || format == Format::kWide;
  }
};

enum class Cell : std::uint8_t { kText, kCount, kBytes, kDuration, kRate, kPercent };

// One column of a table, or one line of a page.
struct Column {
  std::string_view title;  // "AGE"
  std::string_view path;   // "age_s"
  Cell as = Cell::kText;
  bool wide = false;   // only with -o wide (and in CSV)
  bool alarm = false;  // red when it is not 0
};

enum class Tone : std::uint8_t { kPlain, kBold, kDim, kGood, kWarning, kBad };
// With escape codes if colours are wanted; widths must be counted before.
std::string paint(std::string_view text, Tone tone, bool colour);

// In quotes where CSV needs them.
std::string csv_cell(std::string text);

// One value as a person reads it; "-" when it is not there.
std::string cell_text(const json::object& item, const Column& column);

// The items in the look's format (anything but JSON). Every row ends with a newline.
std::string render_items(std::span<const json::value> items, std::span<const Column> columns,
                         const Look& look);
// One object, a line a column: "Uptime:  3d 4h".
std::string render_page(const json::object& object, std::span<const Column> lines,
                        const Look& look);

// Orders by a column: numbers from large to small, texts from A to Z. Throws Failure for a column
// that is not there.
void sort_items(json::array& items, std::span<const Column> columns, std::string_view by);

class Output {
 public:
  Output(const Options& options, bool no_color);

  [[nodiscard]] const Look& look() const { return look_; }
  [[nodiscard]] bool terminal() const { return terminal_; }
  [[nodiscard]] bool json() const { return look_.format == Format::kJson; }

  // To stdout, at once. Throws Interrupted when nobody reads it any more.
  void write(std::string_view text);
  void write(const json::object& object);  // one line
  // The answer as JSON, if that is wanted; else the text.
  void write(const json::object& answer, const std::function<std::string()>& text);
  // Over what was written before, when that can be done: a display that is drawn again and again.
  void redraw(std::string_view text);

  // To stderr: remarks that -q silences, and those only -v wants to see.
  void note(std::string_view text) const;
  void detail(std::string_view text) const;
  // As JSON on stdout, or as text on stderr.
  void failure(const Failure& failure) const;

 private:
  Look look_;
  bool terminal_;
  bool quiet_;
  bool verbose_;
};

// "02:15:00.123", of this place; with Z when it is UTC.
std::string time_of_day(base::WallTime time, bool utc);
// The time of day of an RFC 3339 time; the text itself when it is none.
std::string local_time(std::string_view rfc3339_text, bool utc);

}  // namespace timsctl
