#include "tools/cli/output.h"

#include <algorithm>

#include <boost/json/serialize.hpp>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "base/text.h"
#include "os/clock.h"
#include "tools/cli/pager.h"

namespace timsctl {

const json::value* at_path(const json::object& object, std::string_view path) {
  const json::object* in = &object;
  for (;;) {
    const std::size_t dot = path.find('.');
    const json::value* value = in->if_contains(path.substr(0, dot));
    if (value == nullptr || value->is_null()) return nullptr;
    if (dot == std::string_view::npos) return value;
    in = value->if_object();
    if (in == nullptr) return nullptr;
    path.remove_prefix(dot + 1);
  }
}

std::optional<double> number_at(const json::object& object, std::string_view path) {
  const json::value* value = at_path(object, path);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  return value->to_number<double>();
}

double number_or_zero(const json::object& object, std::string_view path) {
  return number_at(object, path).value_or(0);
}

std::string text_at(const json::object& object, std::string_view path) {
  const json::value* value = at_path(object, path);
  if (value == nullptr) return {};
  if (const json::string* text = value->if_string()) return std::string(*text);
  return to_text(*value);
}

json::value json_of(const tims::base::TomlNode& node) {
  if (node.form == tims::base::TomlNode::Form::kTable) {
    json::object object;
    for (const tims::base::TomlNode& child : node.children) object[child.key] = json_of(child);
    return object;
  }
  if (node.form == tims::base::TomlNode::Form::kArray) {
    json::array list;
    for (const tims::base::TomlNode& child : node.children) list.push_back(json_of(child));
    return list;
  }
  if (const auto* text = std::get_if<std::string>(&node.value)) return json::value(*text);
  if (const auto* flag = std::get_if<bool>(&node.value)) return *flag;
  if (const auto* whole = std::get_if<std::int64_t>(&node.value)) return *whole;
  if (const auto* real = std::get_if<double>(&node.value)) return *real;
  return nullptr;
}

std::span<const json::value> items_of(const json::object& answer, std::string_view list) {
  const json::value* items = answer.if_contains(list);
  const json::array* array = items == nullptr ? nullptr : items->if_array();
  if (array == nullptr) return {};
  return {array->data(), array->size()};
}

json::array& item_array(json::object& answer) {
  json::value& items = answer["items"];
  return items.is_array() ? items.get_array() : items.emplace_array();
}

std::string to_text(const json::value& value) { return json::serialize(value); }

namespace {

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(file, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

bool right_aligned(const Column& column) { return column.as != Cell::kText; }

std::vector<Column> chosen(std::span<const Column> columns, Format format) {
  if (format == Format::kName) return {columns.front()};
  std::vector<Column> out;
  for (const Column& column : columns)
    if (!column.wide || format == Format::kWide || format == Format::kCsv) out.push_back(column);
  return out;
}

std::string padded(std::string_view text, std::size_t width, bool right, bool last) {
  const std::size_t wide = base::display_width(text);
  const std::string blanks(width > wide ? width - wide : 0, ' ');
  if (right) return blanks + std::string(text);
  return last ? std::string(text) : std::string(text) + blanks;
}

std::string render_csv(std::span<const json::value> items, std::span<const Column> columns) {
  std::string out;
  for (const Column& column : columns) out.append(out.empty() ? "" : ",").append(column.path);
  out += '\n';
  for (const json::value& item : items) {
    std::string row;
    for (const Column& column : columns)
      row.append(&column == columns.data() ? "" : ",")
          .append(csv_cell(text_at(item.as_object(), column.path)));
    out.append(row).append("\n");
  }
  return out;
}

Tone tone_of(const json::object& item, const Column& column) {
  if (column.alarm && number_or_zero(item, column.path) != 0) return Tone::kBad;
  return Tone::kPlain;
}

std::string render_table(std::span<const json::value> items, std::span<const Column> columns,
                         bool header, bool colour) {
  std::vector<std::vector<std::string>> cells;
  std::vector<std::size_t> widths(columns.size(), 0);
  for (std::size_t c = 0; header && c < columns.size(); ++c)
    widths[c] = base::display_width(columns[c].title);
  for (const json::value& item : items) {
    auto& row = cells.emplace_back();
    for (std::size_t c = 0; c < columns.size(); ++c) {
      row.push_back(cell_text(item.as_object(), columns[c]));
      widths[c] = std::max(widths[c], base::display_width(row.back()));
    }
  }
  std::string out;
  const auto add = [&](std::size_t c, std::string_view text, Tone tone) {
    const bool last = c + 1 == columns.size();
    out += paint(padded(text, widths[c], right_aligned(columns[c]), last), tone, colour);
    out += last ? "\n" : "  ";
  };
  for (std::size_t c = 0; header && c < columns.size(); ++c) add(c, columns[c].title, Tone::kBold);
  for (std::size_t r = 0; r < cells.size(); ++r)
    for (std::size_t c = 0; c < columns.size(); ++c)
      add(c, cells[r][c], tone_of(items[r].as_object(), columns[c]));
  return out;
}

}  // namespace

Output::Output(const Options& options, bool no_color)
    : look_{.format = options.format, .utc = options.utc, .sort = options.sort},
      terminal_(::isatty(STDOUT_FILENO) == 1),
      quiet_(options.quiet),
      verbose_(options.verbose) {
  look_.colour = terminal_ && !no_color && !options.no_color;
}

void Output::write(std::string_view text) {
  if (!write_all(STDOUT_FILENO, text)) throw Interrupted();
}

void Output::write(const json::object& object) { write(to_text(object) + "\n"); }

void Output::write(const json::object& answer, const std::function<std::string()>& text) {
  json() ? write(answer) : write_pages(text());
}

void Output::write_pages(std::string_view text) {
  if (!terminal_ || !show_in_pager(text)) write(text);
}

void Output::redraw(std::string_view text) {
  if (!terminal_) return write(text);
  winsize size{};
  ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size);
  std::size_t lines_left = size.ws_row == 0 ? SIZE_MAX : size.ws_row - 1U;
  // Move to the top left, erase the rest of each old line and everything below. Long lines are cut,
  // because wrapping is switched off during the output.
  std::string frame = "\033[?7l\033[H";
  for (const char c : text) {
    if (c == '\n' && lines_left-- <= 1) break;
    if (c == '\n') frame += "\033[K";
    frame += c;
  }
  write(frame + "\033[K\033[J\033[?7h");
}

void Output::note(std::string_view text) const {
  if (!quiet_) write_all(STDERR_FILENO, fmt::format("{}\n", base::printable(text)));
}

void Output::detail(std::string_view text) const {
  if (verbose_) note(text);
}

void Output::failure(const Failure& failure) const {
  if (json()) {
    json::object error{{"code", failure.code}, {"message", failure.message}};
    if (!failure.hint.empty()) error["hint"] = failure.hint;
    write_all(STDOUT_FILENO,
              to_text(json::object{{"schema", "tims/error/1"}, {"error", error}}) + "\n");
    return;
  }
  write_all(STDERR_FILENO, failure_text(failure));
}

std::string csv_cell(std::string text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  return out + '"';
}

std::string paint(std::string_view text, Tone tone, bool colour) {
  if (!colour || tone == Tone::kPlain) return std::string(text);
  constexpr std::string_view kCodes[] = {"0", "1", "2", "32", "33", "31"};
  return fmt::format("\033[{}m{}\033[0m", kCodes[static_cast<std::size_t>(tone)], text);
}

std::string cell_text(const json::object& item, const Column& column) {
  if (column.as == Cell::kText) {
    std::string text = base::printable(text_at(item, column.path));
    return text.empty() ? "-" : text;
  }
  const auto value = number_at(item, column.path);
  if (!value) return "-";
  switch (column.as) {
    case Cell::kBytes:
      return base::human_bytes(*value);
    case Cell::kDuration:
      return base::human_duration(*value);
    case Cell::kRate:
      return base::human_rate(*value);
    case Cell::kPercent:
      return fmt::format("{:.1f}%", *value * 100);
    default:
      return base::human_count(*value);
  }
}

std::string render_items(std::span<const json::value> items, std::span<const Column> columns,
                         const Look& look) {
  const auto shown = chosen(columns, look.format);
  switch (look.format) {
    case Format::kCsv:
      return render_csv(items, shown);
    case Format::kName:
    case Format::kPlain:
      return render_table(items, shown, false, false);
    default:
      return render_table(items, shown, true, look.colour);
  }
}

std::string render_page(const json::object& object, std::span<const Column> lines,
                        const Look& look) {
  if (look.format == Format::kCsv || look.format == Format::kName) {
    const json::value item(object);
    return render_items({&item, 1}, lines, look);
  }
  std::size_t width = 0;
  for (const Column& line : lines) width = std::max(width, base::display_width(line.title) + 1);
  std::string out;
  for (const Column& line : lines) {
    if (line.wide && look.format != Format::kWide) continue;
    const std::string title = std::string(line.title) + ":";
    out += paint(padded(title, width, false, false), Tone::kBold, look.colour) + "  ";
    out += paint(cell_text(object, line), tone_of(object, line), look.colour) + "\n";
  }
  return out;
}

void sort_items(json::array& items, std::span<const Column> columns, std::string_view by) {
  const std::string wanted = base::lower(by);
  const auto column = std::ranges::find_if(
      columns, [&](const Column& c) { return base::lower(c.title) == wanted || c.path == wanted; });
  if (column == columns.end()) {
    std::string names;
    for (const Column& c : columns)
      names.append(names.empty() ? "" : ", ").append(base::lower(c.title));
    throw usage_error("no column \"" + std::string(by) + "\"", "columns: " + names);
  }
  std::stable_sort(items.begin(), items.end(), [&](const json::value& a, const json::value& b) {
    if (right_aligned(*column))
      return number_or_zero(a.as_object(), column->path) >
             number_or_zero(b.as_object(), column->path);
    return text_at(a.as_object(), column->path) < text_at(b.as_object(), column->path);
  });
}

std::string time_of_day(base::WallTime time, bool utc) {
  if (utc) return base::time_of_day(time) + "Z";
  return base::time_of_day(time + tims::os::utc_offset(time));
}

std::string local_time(std::string_view rfc3339_text, bool utc) {
  const auto time = base::parse_rfc3339(rfc3339_text);
  return time ? time_of_day(*time, utc) : std::string(rfc3339_text);
}

}  // namespace timsctl
