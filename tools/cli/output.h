// Access to optional members of JSON; conversion to tables, pages, CSV and names (pure); output of
// results to stdout and notes to stderr.
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
#include "base/toml.h"
#include "tools/cli/failure.h"
#include "tools/cli/options.h"

namespace timsctl {

namespace json = boost::json;

// `path` may be nested: "owner.name". nullptr if the member is missing or null.
const json::value* at_path(const json::object& object, std::string_view path);
std::optional<double> number_at(const json::object& object, std::string_view path);
double number_or_zero(const json::object& object, std::string_view path);
// A string as it is, other values as JSON; empty if missing.
std::string text_at(const json::object& object, std::string_view path);
// The elements of the list; empty if it is missing.
std::span<const json::value> items_of(const json::object& answer, std::string_view list = "items");
std::span<const json::value> items_of(json::object&& gone,
                                      std::string_view list = "items") = delete;
json::array& item_array(json::object& answer);  // created if missing
inline auto objects(std::span<const json::value> items) {
  return std::views::transform(
      items, [](const json::value& item) -> const json::object& { return item.as_object(); });
}
void objects(json::array&& gone) = delete;

std::string to_text(const json::value& value);  // compact, one line
json::value json_of(const tims::base::TomlNode& node);

// Conversion of JSON items to text: aligned tables, plain rows, CSV, names. Pure.

// The appearance of the output.
struct Look {
  Format format = Format::kTable;
  bool colour = false;
  bool utc = false;
  std::string sort{};  // title or path of a column, case-insensitive

  // Text for humans, not uniform rows.
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
// Adds escape codes if `colour`; compute widths before.
std::string paint(std::string_view text, Tone tone, bool colour);

// Quotes the text if CSV requires it.
std::string csv_cell(std::string text);

// One value as text; "-" if missing.
std::string cell_text(const json::object& item, const Column& column);

// The items in the format of the look (except JSON). Every row ends with a newline.
std::string render_items(std::span<const json::value> items, std::span<const Column> columns,
                         const Look& look);
// One object, one line per column: "Uptime:  3d 4h".
std::string render_page(const json::object& object, std::span<const Column> lines,
                        const Look& look);

// Sorts by a column: numbers in descending, texts in ascending order. Throws Failure if there is no
// such column.
void sort_items(json::array& items, std::span<const Column> columns, std::string_view by);

class Output {
 public:
  Output(const Options& options, bool no_color);

  [[nodiscard]] const Look& look() const { return look_; }
  [[nodiscard]] bool terminal() const { return terminal_; }
  [[nodiscard]] bool json() const { return look_.format == Format::kJson; }

  // Writes to stdout, unbuffered. Throws Interrupted if the reader has closed it.
  void write(std::string_view text);
  void write(const json::object& object);  // one line
  // Writes a text that is complete; page by page if it is longer than the terminal.
  void write_pages(std::string_view text);
  // Writes the answer as JSON if requested, else the text, page by page.
  void write(const json::object& answer, const std::function<std::string()>& text);
  // Overwrites the previous display if stdout is a terminal.
  void redraw(std::string_view text);

  // Write to stderr: notes (not with -q) and details (only with -v).
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

// "02:15:00.123" in local time, or with Z in UTC.
std::string time_of_day(base::WallTime time, bool utc);
// The time of day of an RFC 3339 time; the unchanged text if it is not one.
std::string local_time(std::string_view rfc3339_text, bool utc);

}  // namespace timsctl
