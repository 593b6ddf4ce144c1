#include "tools/timsctl/message.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <iterator>

#include <boost/json/parse.hpp>
#include <fmt/format.h>

#include "base/text.h"
#include "proxies/message_files.h"
#include "rack/proxies/generic.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"

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

// Parses the output of dump().
class DumpReader {
 public:
  std::vector<Draft> read(std::string_view text) {
    for (const std::string_view line : parts_of(text, '\n')) {
      ++line_;
      read_line(line);
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
      refuse(line_, "the body is incomplete: it was shortened for a terminal");
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
      const auto value = base::parse_number<std::uint64_t>(field(name));
      if (!value || *value > max) refuse(line_, fmt::format("{} is not a valid number", name));
      return *value;
    };
    Draft& draft = drafts_.back();
    const auto type = parse_type(field(" type="));
    if (!type) refuse(line_, "type= is not a message type");
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
    const auto row =
        gap == std::string_view::npos ? std::nullopt : base::parse_hex(hex.substr(gap));
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
  const auto body = base::parse_hex(text_at(object, "body_hex"));
  const auto type = parse_type(text_at(object, "type"));
  if (!body || !type) refuse(line, "type or body_hex is invalid");
  const auto number = [&](std::string_view name) {
    const double n = number_or_zero(object, name);
    if (n < 0 || n > 255) refuse(line, fmt::format("{} is not a valid number", name));
    return static_cast<std::uint8_t>(n);
  };
  return {.type = *type,
          .priority = number("priority"),
          .seq_nr = number("seq_nr"),
          .little_endian = text_at(object, "body_order") != "big",
          .body = *body};
}

// The reason of a refusal; empty for other messages.
std::string_view reason_in(const Message& message) {
  return message.header.type == tims::type::kError ? rack::reason_of(message.body)
                                                   : std::string_view();
}

rack::PrintStyle print_style(const FieldStyle& style) {
  return {.elements_max = style.elements_max,
          .si = style.si,
          .one_line = !style.fields,
          .widths = style.widths};
}

const rack::Schema* body_of(const Message& message, const tims::AddressWidths& widths) {
  const rack::MessageInfo* info = rack::find_message(message.header, widths);
  return info == nullptr ? nullptr : info->body;
}

std::string heading(const Message& message, base::WallTime time, const FieldStyle& style) {
  const tims::Header& header = message.header;
  std::string out =
      fmt::format("{} {}", time_of_day(time, style.utc), header.src.to_string(style.widths));
  if (style.header) out += " -> " + header.dest.to_string(style.widths);
  out += " " + type_name(header, style.widths);
  if (style.header)
    out += fmt::format(" (priority {}, seq {}, {} bytes)", header.priority, header.seq_nr,
                       message.body.size());
  return out;
}

std::string indented(std::string_view lines) {
  std::string out;
  for (const std::string_view line : parts_of(lines, '\n'))
    if (!line.empty()) out.append("  ").append(line).append("\n");
  return out;
}

// The name in the catalogue: "points[].distance" for "points[3].distance".
std::string without_indices(std::string_view name) {
  std::string out;
  bool inside = false;
  for (const char c : name) {
    if (c == ']') inside = false;
    if (!inside) out += c;
    if (c == '[') inside = true;
  }
  return out;
}

// Calls fits() for each value at the path until it returns true.
template <typename Fits>
bool any_at(const json::value& value, std::string_view path, const Fits& fits) {
  if (path.empty()) return fits(value);
  if (path.starts_with('[')) {
    const json::array* list = value.if_array();
    const std::size_t end = path.find(']');
    if (list == nullptr || end == std::string_view::npos) return false;
    const std::string_view behind = path.substr(end + 1);
    const std::string_view index = path.substr(1, end - 1);
    if (index.empty())
      return std::ranges::any_of(*list,
                                 [&](const json::value& v) { return any_at(v, behind, fits); });
    const auto at = base::parse_number<std::uint64_t>(index);
    return at && *at < list->size() && any_at((*list)[*at], behind, fits);
  }
  if (path.starts_with('.')) path.remove_prefix(1);
  const std::size_t end = std::min(path.find_first_of(".["), path.size());
  const json::object* object = value.if_object();
  const json::value* member =
      object == nullptr ? nullptr : object->if_contains(path.substr(0, end));
  return member != nullptr && any_at(*member, path.substr(end), fits);
}

std::optional<double> as_number(std::string_view text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (text.empty() || error != std::errc() || stop != end) return std::nullopt;
  return value;
}

bool compare(std::partial_ordering order, std::string_view relation) {
  if (relation == "=") return order == 0;
  if (relation == "!=") return order != 0;
  if (relation == "<") return order < 0;
  if (relation == "<=") return order <= 0;
  if (relation == ">") return order > 0;
  return order >= 0;
}

bool holds(const json::value& value, std::string_view relation, const std::string& wanted,
           const tims::AddressWidths& widths) {
  const auto number = as_number(wanted);
  if (number && value.is_number()) return compare(value.to_number<double>() <=> *number, relation);
  const json::string* text = value.if_string();
  const std::string found = text == nullptr ? to_text(value) : std::string(*text);
  // "Ladar/0/0" is the same address as "Ladar(0/0)".
  if (const auto address = parse_address(wanted, widths); address && text != nullptr)
    if (const auto other = parse_address(found, widths))
      return compare(*other <=> *address, relation);
  return compare(found <=> wanted, relation);
}

// Appends all fields with their paths: {"data.pos.x", value}.
void flatten(const json::object& object, const std::string& prefix,
             std::vector<std::pair<std::string, std::string>>& out) {
  for (const auto& [key, value] : object) {
    const std::string name = prefix + std::string(key);
    if (const json::object* inner = value.if_object()) {
      flatten(*inner, name + ".", out);
    } else {
      const json::string* text = value.if_string();
      const std::string cell = value.is_null()   ? ""
                               : text != nullptr ? std::string(*text)
                                                 : to_text(value);
      out.emplace_back(name, cell);
    }
  }
}

std::string nearest_hint(std::string_view name, const std::vector<std::string>& known,
                         const std::string& otherwise) {
  const std::vector<std::string_view> views(known.begin(), known.end());
  const auto near = base::nearest(name, views);
  return near ? fmt::format("did you mean {}?", *near) : otherwise;
}

std::vector<std::string> names_of(const rack::Schema& body) {
  std::vector<std::string> names;
  for (const rack::Column& column : columns_of(body)) names.push_back(column.name);
  return names;
}

std::string listed(const std::vector<std::string>& names) {
  return fmt::format("known: {}", fmt::join(names, ", "));
}

}  // namespace

std::string dump(const Message& message, base::WallTime time, const DumpStyle& style) {
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

json::object message_json(const Message& message, base::WallTime time,
                          const tims::AddressWidths& widths) {
  const tims::Header& header = message.header;
  const std::string name = type_name(header, widths);
  return {{"schema", "tims/message/1"},
          {"time", base::rfc3339(time)},
          {"type", header.type},
          {"type_name", name.empty() ? json::value() : json::value(name)},
          {"src", address_json(header.src, widths)},
          {"dest", address_json(header.dest, widths)},
          {"priority", header.priority},
          {"seq_nr", header.seq_nr},
          {"body_order", is_little(header) ? "little" : "big"},
          {"body_bytes", message.body.size()},
          {"body_hex", base::to_hex(message.body)}};
}

bool is_recorded(std::string_view text) {
  return text.starts_with(kMark) || text.starts_with(R"({"schema":"tims/message/1")");
}

std::vector<Draft> parse_recorded(std::string_view text) {
  if (text.starts_with(kMark)) return DumpReader().read(text);
  std::vector<Draft> drafts;
  std::size_t number = 0;
  for (const std::string_view line : parts_of(text, '\n'))
    if (++number; !line.empty()) drafts.push_back(read_json_line(number, line));
  return drafts;
}

std::string describe(const Message& message, base::WallTime time, const FieldStyle& style) {
  if (const std::string_view reason = reason_in(message); !reason.empty())
    return heading(message, time, style) + ": " + base::printable(reason) + "\n";
  const rack::MessageInfo* info = rack::find_message(message.header, style.widths);
  const bool has_body = info != nullptr && info->body != nullptr;
  if (info == nullptr || (!has_body && !message.body.empty()))
    return dump(message, time, {.widths = style.widths, .utc = style.utc});
  const std::string head = heading(message, time, style);
  if (!has_body) return head + "\n";
  const auto text =
      rack::body_text(*info->body, message.body, message.header.body_order(), print_style(style));
  if (!text) {
    const std::string bytes = dump(message, time, {.widths = style.widths, .utc = style.utc});
    return fmt::format("{}: {}\n{}", head, base::printable(text.error().detail()), bytes);
  }
  return style.fields ? head + "\n" + indented(*text) : head + " " + *text + "\n";
}

json::object units_json(const rack::Schema& body, bool si) {
  json::object units;
  for (const rack::Column& column : columns_of(body)) {
    const std::string_view unit = si ? column.si_unit : column.unit;
    if (!unit.empty()) units[column.name] = unit;
  }
  return units;
}

json::object described_json(const Message& message, base::WallTime time, const FieldStyle& style) {
  json::object out = message_json(message, time, style.widths);
  if (const std::string_view reason = reason_in(message); !reason.empty())
    out["reason"] = base::printable(reason);
  const rack::Schema* body = body_of(message, style.widths);
  if (body == nullptr) return out;
  out["body"] = body->name;
  const auto text =
      rack::body_json(*body, message.body, message.header.body_order(), print_style(style));
  if (!text) {
    out["malformed"] = text.error().detail();
    return out;
  }
  out["units"] = units_json(*body, style.si);
  out["data"] = json::parse(*text);
  return out;
}

std::string CsvLines::add(const json::object& described) {
  std::vector<std::pair<std::string, std::string>> cells;
  for (const char* name : {"time", "type_name", "src", "dest"}) {
    const bool address = at_path(described, std::string(name) + ".name") != nullptr;
    cells.emplace_back(name, text_at(described, std::string(name) + (address ? ".name" : "")));
  }
  if (const json::value* data = at_path(described, "data"))
    flatten(data->as_object(), "", cells);
  else
    cells.emplace_back("body_hex", text_at(described, "body_hex"));
  std::string names;
  std::string line;
  for (const auto& [name, cell] : cells) {
    names.append(names.empty() ? "" : ",").append(csv_cell(name));
    line.append(&name == &cells.front().first ? "" : ",").append(csv_cell(cell));
  }
  line += '\n';
  if (names == names_) return line;
  names_ = names;
  return names + "\n" + line;
}

FieldFilter::FieldFilter(std::string_view text, const tims::AddressWidths& widths)
    : widths_(widths) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    const std::string_view part = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t at = part.find_first_of("=!<>");
    std::size_t behind = at == std::string_view::npos ? at : part.find_first_not_of("=!<>", at);
    if (behind == std::string_view::npos) behind = part.size();
    std::string relation(at == std::string_view::npos ? "" : part.substr(at, behind - at));
    if (relation == "==") relation = "=";
    const std::string_view known[] = {"=", "!=", "<", "<=", ">", ">="};
    if (at == 0 || std::ranges::find(known, relation) == std::end(known))
      throw usage_error(fmt::format("--filter: \"{}\" is not a condition", part),
                        "such as 'vx>100' or 'type_name=move,priority>=10'");
    conditions_.push_back(
        {std::string(part.substr(0, at)), std::move(relation), std::string(part.substr(behind))});
  }
}

void FieldFilter::check(const rack::Schema& body) const {
  const json::object any = message_json({}, {}, {});
  std::vector<std::string> names = names_of(body);
  for (const Condition& condition : conditions_) {
    const bool field = std::ranges::any_of(names, [&](const std::string& name) {
      return without_indices(name) == without_indices(condition.name);
    });
    if (field || any_at(any, condition.name, [](const json::value&) { return true; })) continue;
    throw usage_error(fmt::format("--filter: {} has no field {}", body.name, condition.name),
                      nearest_hint(condition.name, names, listed(names)));
  }
}

bool FieldFilter::passes(const json::object& described) const {
  const json::value* data = at_path(described, "data");
  return std::ranges::all_of(conditions_, [&](const Condition& c) {
    const auto fits = [&](const json::value& v) { return holds(v, c.relation, c.value, widths_); };
    if (data != nullptr && any_at(*data, c.name, fits)) return true;
    const bool is_address = c.name == "src" || c.name == "dest";
    return any_at(described, is_address ? c.name + ".name" : c.name, fits);
  });
}

std::string undescribed(std::uint32_t class_id) {
  if (class_id == rack::kEveryClass || !tims::class_name(class_id).empty()) return {};
  return fmt::format("the messages of class {} are not described", rack::class_number(class_id));
}

std::vector<std::byte> make_body(const rack::MessageInfo& message, std::uint32_t class_id,
                                 const std::vector<std::string>& assignments,
                                 const FieldStyle& style) {
  const std::string show =
      fmt::format("timsctl msg show {} {}", tims::class_name(class_id), base::lower(message.name));
  if (message.body == nullptr) {
    if (assignments.empty()) return {};
    throw usage_error(fmt::format("{} has no fields", base::lower(message.name)), show);
  }
  const auto columns = rack::columns_of(*message.body);
  std::vector<rack::Assignment> fields;
  std::vector<std::string> addresses;  // storage for address values
  addresses.reserve(assignments.size());
  for (const std::string& text : assignments) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos)
      throw usage_error(fmt::format("\"{}\" is not of the form FIELD=VALUE", text), show);
    const std::string_view name = std::string_view(text).substr(0, equals);
    std::string_view value = std::string_view(text).substr(equals + 1);
    const auto column = std::ranges::find_if(columns, [&](const rack::Column& c) {
      return without_indices(c.name) == without_indices(name);
    });
    // Users write "Pilot/0/1", which needs no quotes; the codec accepts only "Pilot(0/1)".
    if (column != columns.end() && column->type == "address" && value != "none")
      value = addresses.emplace_back(need_address(value, style.widths).to_hex());
    fields.push_back({name, value});
  }
  auto body = rack::make_body(*message.body, fields, std::endian::native, print_style(style));
  if (body) return *std::move(body);
  const std::string& what = body.error().detail();
  std::string hint = show;
  if (what.find(" has no field ") != std::string::npos) {
    const std::string name = what.substr(what.find('"') + 1, what.rfind('"') - what.find('"') - 1);
    hint = nearest_hint(name, names_of(*message.body), listed(names_of(*message.body)));
  }
  throw usage_error(what, hint);
}

const rack::MessageInfo& need_message(std::uint32_t class_id, std::string_view name) {
  const auto number = parse_type(name, class_id);
  const rack::MessageInfo* found =
      number ? rack::find_message(class_id, *number) : rack::find_message(class_id, name);
  if (found != nullptr) return *found;
  std::vector<std::string> names;
  for (const auto table : rack::message_tables())
    for (const rack::MessageInfo& message : table)
      if (message.class_id == class_id || message.class_id == rack::kEveryClass)
        names.push_back(base::lower(message.name));
  const std::string of_class(tims::class_name(class_id));
  if (const std::string why = undescribed(class_id); !why.empty())
    throw usage_error(fmt::format("\"{}\" is not a message of every class, and {}", name, why),
                      rack::message_places());
  throw usage_error(
      fmt::format("{}{}\"{}\" is not a message", of_class, of_class.empty() ? "" : ": ", name),
      nearest_hint(base::lower(name), names, fmt::format("timsctl msg types {}", of_class)));
}

std::int8_t need_type(std::string_view text, std::uint32_t class_id) {
  const auto type = parse_type(text, class_id);
  return type ? *type : need_message(class_id, text).type;
}

std::int8_t type_to_assume(const Options& options, tims::Address to,
                           const tims::AddressWidths& widths) {
  if (options.type.empty()) return tims::type::kGetStatus;
  return need_type(options.type, to.fields(widths).class_id);
}

}  // namespace timsctl
