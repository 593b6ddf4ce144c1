#include "tools/timsctl/render.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

bool right_aligned(const Column& column) { return column.as != As::kText; }

std::vector<Column> chosen(std::span<const Column> columns, Format format) {
  if (format == Format::kName) return {columns.front()};
  std::vector<Column> out;
  for (const Column& column : columns)
    if (!column.wide || format == Format::kWide || format == Format::kCsv) out.push_back(column);
  return out;
}

std::string padded(std::string_view text, std::size_t width, bool right, bool last) {
  const std::size_t wide = display_width(text);
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
    widths[c] = display_width(columns[c].title);
  for (const json::value& item : items) {
    auto& row = cells.emplace_back();
    for (std::size_t c = 0; c < columns.size(); ++c) {
      row.push_back(cell_text(item.as_object(), columns[c]));
      widths[c] = std::max(widths[c], display_width(row.back()));
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
  if (column.as == As::kText) {
    std::string text = printable(text_at(item, column.path));
    return text.empty() ? "-" : text;
  }
  const auto value = number_at(item, column.path);
  if (!value) return "-";
  switch (column.as) {
    case As::kBytes:
      return human_bytes(*value);
    case As::kDuration:
      return human_duration(*value);
    case As::kRate:
      return human_rate(*value);
    case As::kPercent:
      return fmt::format("{:.1f}%", *value * 100);
    default:
      return human_count(*value);
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
  for (const Column& line : lines) width = std::max(width, display_width(line.title) + 1);
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
  const std::string wanted = lower(by);
  const auto column = std::ranges::find_if(
      columns, [&](const Column& c) { return lower(c.title) == wanted || c.path == wanted; });
  if (column == columns.end()) {
    std::string names;
    for (const Column& c : columns) names.append(names.empty() ? "" : ", ").append(lower(c.title));
    throw usage_error("no column \"" + std::string(by) + "\"", "there are " + names);
  }
  std::stable_sort(items.begin(), items.end(), [&](const json::value& a, const json::value& b) {
    if (right_aligned(*column))
      return number_or_zero(a.as_object(), column->path) >
             number_or_zero(b.as_object(), column->path);
    return text_at(a.as_object(), column->path) < text_at(b.as_object(), column->path);
  });
}

}  // namespace timsctl
