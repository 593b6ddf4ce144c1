// A longest common subsequence of lines (dynamic programming) between the equal lines at the
// beginning and at the end. Where that would be too large, all lines in between count as changed.
#include "tools/configuration/differences.h"

#include <algorithm>
#include <cstdint>
#include <span>

namespace timsctl::configuration {
namespace {

using Lines = std::vector<std::string_view>;

constexpr std::size_t kCellsMax = 4U << 20;
constexpr std::size_t kAround = 3;

Lines lines_of(std::string_view text) {
  Lines lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    lines.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return lines;
}

struct Row {
  char mark = ' ';  // ' ', '-', '+'
  std::string_view line{};
};

void append_changed(std::span<const std::string_view> a, std::span<const std::string_view> b,
                    std::vector<Row>& rows) {
  const std::size_t width = b.size() + 1;
  if ((a.size() + 1) * width > kCellsMax) {
    for (const auto& line : a) rows.push_back({'-', line});
    for (const auto& line : b) rows.push_back({'+', line});
    return;
  }
  // Of the rest behind these lines.
  std::vector<std::uint32_t> common((a.size() + 1) * width);
  for (std::size_t i = a.size(); i-- > 0;)
    for (std::size_t j = b.size(); j-- > 0;)
      common[i * width + j] =
          a[i] == b[j] ? common[(i + 1) * width + j + 1] + 1
                       : std::max(common[(i + 1) * width + j], common[i * width + j + 1]);
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() || j < b.size()) {
    if (i < a.size() && j < b.size() && a[i] == b[j]) {
      rows.push_back({' ', a[i++]});
      ++j;
    } else if (j == b.size() ||
               (i < a.size() && common[(i + 1) * width + j] >= common[i * width + j + 1])) {
      rows.push_back({'-', a[i++]});
    } else {
      rows.push_back({'+', b[j++]});
    }
  }
}

std::vector<Row> rows_of(const Lines& a, const Lines& b) {
  std::size_t head = 0;
  while (head < a.size() && head < b.size() && a[head] == b[head]) ++head;
  std::size_t tail = 0;
  while (tail < a.size() - head && tail < b.size() - head &&
         a[a.size() - 1 - tail] == b[b.size() - 1 - tail])
    ++tail;
  std::vector<Row> rows;
  for (std::size_t i = 0; i < head; ++i) rows.push_back({' ', a[i]});
  append_changed(std::span(a).subspan(head, a.size() - head - tail),
                 std::span(b).subspan(head, b.size() - head - tail), rows);
  for (std::size_t i = a.size() - tail; i < a.size(); ++i) rows.push_back({' ', a[i]});
  return rows;
}

class Hunks {
 public:
  explicit Hunks(const std::vector<Row>& rows) : rows_(rows) {}

  std::string run() {
    for (std::size_t at = 0; at < rows_.size();) {
      const std::size_t first = next_change(at);
      if (first == rows_.size()) break;
      const std::size_t begin = std::max(at, first - std::min(first, kAround));
      std::size_t end = first + 1;
      while (next_change(end) <= end + 2 * kAround && next_change(end) < rows_.size())
        end = next_change(end) + 1;
      end = std::min(end + kAround, rows_.size());
      count(at, begin);
      append(begin, end);
      at = end;
    }
    return std::move(text_);
  }

 private:
  [[nodiscard]] std::size_t next_change(std::size_t from) const {
    while (from < rows_.size() && rows_[from].mark == ' ') ++from;
    return from;
  }
  void count(std::size_t begin, std::size_t end) {
    for (; begin < end; ++begin) {
      before_ += rows_[begin].mark != '+' ? 1 : 0;
      after_ += rows_[begin].mark != '-' ? 1 : 0;
    }
  }
  void append(std::size_t begin, std::size_t end) {
    const std::size_t before = before_;
    const std::size_t after = after_;
    count(begin, end);
    const auto range = [](std::size_t from, std::size_t to) {
      return std::to_string(from + (to > from ? 1 : 0)) + "," + std::to_string(to - from);
    };
    text_ += "@@ -" + range(before, before_) + " +" + range(after, after_) + " @@\n";
    for (std::size_t i = begin; i < end; ++i) {
      text_ += rows_[i].mark;
      text_ += rows_[i].line;
      if (!rows_[i].line.ends_with('\n')) text_ += "\n\\ No newline at end of file\n";
    }
  }

  const std::vector<Row>& rows_;
  std::string text_;
  std::size_t before_ = 0;  // lines
  std::size_t after_ = 0;
};

}  // namespace

TextDifference difference(std::string_view name, std::string_view before, std::string_view after) {
  TextDifference made;
  if (before == after) return made;
  const Lines a = lines_of(before);
  const Lines b = lines_of(after);
  const std::vector<Row> rows = rows_of(a, b);
  for (const Row& row : rows) {
    made.added += row.mark == '+' ? 1 : 0;
    made.removed += row.mark == '-' ? 1 : 0;
  }
  made.diff = "--- " + std::string(name) + "\n+++ " + std::string(name) + "\n" + Hunks(rows).run();
  return made;
}

}  // namespace timsctl::configuration
