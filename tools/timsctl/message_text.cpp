#include "tools/timsctl/message_text.h"

#include <algorithm>
#include <iterator>

#include <boost/json/parse.hpp>
#include <fmt/format.h>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

constexpr std::string_view kMark = "-- ";
constexpr std::string_view kShortened = "   ... ";
constexpr std::size_t kRow = 16;

bool is_little(const tims::Header& header) { return header.body_order() == std::endian::little; }

void append_row(std::string& out, std::size_t at, std::span<const std::byte> row) {
  fmt::format_to(std::back_inserter(out), "   {:04x} ", at);
  for (std::size_t i = 0; i < kRow; ++i) {
    if (i % 8 == 0) out += ' ';
    if (i < row.size())
      fmt::format_to(std::back_inserter(out), "{:02x} ", std::to_integer<unsigned>(row[i]));
    else
      out += "   ";
  }
  out += " |";
  for (const std::byte b : row) {
    const auto c = std::to_integer<char>(b);
    out += c >= ' ' && c <= '~' ? c : '.';
  }
  out += "|\n";
}

[[noreturn]] void refuse(std::size_t line, std::string_view what) {
  throw usage_error(fmt::format("line {} of the messages: {}", line, what),
                    "write them with `timsctl msg echo`, or send a plain body with --raw");
}

// Reads what dump() writes.
class DumpReader {
 public:
  std::vector<Draft> read(std::string_view text) {
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      ++line_;
      read_line(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    finish();
    return std::move(drafts_);
  }

 private:
  void read_line(std::string_view line) {
    if (line.starts_with(kMark)) {
      finish();
      read_header(line);
    } else if (line.starts_with(kShortened)) {
      refuse(line_, "the body was shortened for a terminal");
    } else if (!line.empty() && line.front() != '#') {
      read_row(line);
    }
  }

  void read_header(std::string_view line) {
    drafts_.emplace_back();
    const auto field = [&](std::string_view name) {
      const std::size_t at = line.find(name);
      if (at == std::string_view::npos) refuse(line_, fmt::format("{} is missing", name));
      const std::string_view rest = line.substr(at + name.size());
      return rest.substr(0, rest.find(' '));
    };
    const auto number = [&](std::string_view name, std::uint64_t max) {
      const auto value = parse_count(field(name));
      if (!value || *value > max) refuse(line_, fmt::format("{} is no such number", name));
      return *value;
    };
    Draft& draft = drafts_.back();
    const auto type = parse_type(field(" type="));
    if (!type) refuse(line_, "type= is no message type");
    draft.type = *type;
    draft.priority = static_cast<std::uint8_t>(number(" priority=", 255));
    draft.seq_nr = static_cast<std::uint8_t>(number(" seq=", 255));
    draft.little_endian = field(" order=") == "little";
    bytes_ = number(" bytes=", UINT32_MAX);
  }

  // "   0010  01 02 ...  |..|"
  void read_row(std::string_view line) {
    if (drafts_.empty()) refuse(line_, "a body before its message");
    const std::string_view hex = line.substr(0, line.find('|'));
    const std::size_t digits = hex.find_first_not_of(' ');
    const std::size_t gap = hex.find(' ', digits);
    const auto row = gap == std::string_view::npos ? std::nullopt : parse_hex(hex.substr(gap));
    if (!row) refuse(line_, "not a row of a body");
    auto& body = drafts_.back().body;
    body.insert(body.end(), row->begin(), row->end());
  }

  void finish() {
    if (!drafts_.empty() && drafts_.back().body.size() != bytes_)
      refuse(line_, fmt::format("the message before has {} bytes, not {}",
                                drafts_.back().body.size(), bytes_));
  }

  std::vector<Draft> drafts_;
  std::uint64_t bytes_ = 0;
  std::size_t line_ = 0;
};

Draft read_json_line(std::size_t line, std::string_view text) {
  boost::system::error_code error;
  const json::value value = json::parse(text, error);
  if (error || !value.is_object()) refuse(line, "not JSON");
  const json::object& object = value.get_object();
  const auto body = parse_hex(text_at(object, "body_hex"));
  const auto type = parse_type(text_at(object, "type"));
  if (!body || !type) refuse(line, "type or body_hex is not one");
  const auto number = [&](std::string_view name) {
    const double n = number_or_zero(object, name);
    if (n < 0 || n > 255) refuse(line, fmt::format("{} is no such number", name));
    return static_cast<std::uint8_t>(n);
  };
  return {.type = *type,
          .priority = number("priority"),
          .seq_nr = number("seq_nr"),
          .little_endian = text_at(object, "body_order") != "big",
          .body = *body};
}

}  // namespace

std::string dump(const Message& message, WallTime time, const DumpStyle& style) {
  const tims::Header& header = message.header;
  const std::string name = type_name(header, style.widths);
  std::string out =
      fmt::format("{}{} {} -> {} type={}{} priority={} seq={} order={} bytes={}\n", kMark,
                  time_of_day(time, style.utc), header.src.to_string(style.widths),
                  header.dest.to_string(style.widths), header.type,
                  name.empty() ? "" : fmt::format(" ({})", name), header.priority, header.seq_nr,
                  is_little(header) ? "little" : "big", message.body.size());
  const auto shown = std::span(message.body).first(std::min(message.body.size(), style.bytes_max));
  for (std::size_t at = 0; at < shown.size(); at += kRow)
    append_row(out, at, shown.subspan(at, std::min(kRow, shown.size() - at)));
  if (shown.size() < message.body.size())
    out +=
        fmt::format("{}{} more bytes: -o wide\n", kShortened, message.body.size() - shown.size());
  return out;
}

json::object message_json(const Message& message, WallTime time,
                          const tims::AddressWidths& widths) {
  const tims::Header& header = message.header;
  const std::string name = type_name(header, widths);
  return {{"schema", "tims/message/1"},
          {"time", rfc3339(time)},
          {"type", header.type},
          {"type_name", name.empty() ? json::value() : json::value(name)},
          {"src", address_json(header.src, widths)},
          {"dest", address_json(header.dest, widths)},
          {"priority", header.priority},
          {"seq_nr", header.seq_nr},
          {"body_order", is_little(header) ? "little" : "big"},
          {"body_bytes", message.body.size()},
          {"body_hex", to_hex(message.body)}};
}

json::object address_json(tims::Address address, const tims::AddressWidths& widths) {
  return {{"name", address.to_string(widths)}, {"raw", address.to_hex()}};
}

bool is_recorded(std::string_view text) {
  return text.starts_with(kMark) || text.starts_with(R"({"schema":"tims/message/1")");
}

std::vector<Draft> parse_recorded(std::string_view text) {
  if (text.starts_with(kMark)) return DumpReader().read(text);
  std::vector<Draft> drafts;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > 0) drafts.push_back(read_json_line(line, text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return drafts;
}

}  // namespace timsctl
