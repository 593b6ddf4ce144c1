#include "tims/address.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace tims {
namespace {

struct ClassName {
  std::uint32_t id;
  std::string_view name;
};

// Printed names of the original RACK (specification, section 2.2), and our own "Tool" and "World".
constexpr ClassName kClassNames[] = {
    {0x00, "Tims"},       {0x01, "GDOS"},    {0x02, "GUI"},      {0x0F, "Tool"},
    {0x10, "Test"},       {0x11, "Chassis"}, {0x12, "Odometry"}, {0x13, "Position"},
    {0x14, "Ladar"},      {0x15, "Camera"},  {0x16, "Gps"},      {0x17, "Joystick"},
    {0x18, "Pilot"},      {0x19, "Scan2d"},  {0x1A, "Datalog"},  {0x1B, "ObjRecog"},
    {0x1C, "Clock"},      {0x1D, "Vehicle"}, {0x1E, "Gyro"},     {0x1F, "Io"},
    {0x20, "ServoDrive"}, {0x21, "Scan3d"},  {0x22, "Planner"},  {0x23, "FeatureMap"},
    {0x24, "GridMap"},    {0x25, "Path"},    {0x26, "Mcl"},      {0x27, "PtzDrive"},
    {0x28, "Compass"},    {0x7F, "World"},
};

// The only global variable of this library: the names of classes are the same in the whole program.
struct OwnClassNames {
  std::array<ClassName, 64> names{};
  std::size_t count = 0;
};
OwnClassNames own;

std::span<const ClassName> own_names() { return std::span(own.names).first(own.count); }

// One field of the text form: a number or "*".
struct Field {
  bool any = false;
  std::uint32_t value = 0;
};

// The parts of "Ladar(3/0):2".
struct Form {
  Field system;
  Field class_id;
  Field instance;
  std::optional<Field> local;
};

std::optional<Form> parse_form(std::string_view text, const AddressWidths& w,
                               std::string* problem = nullptr);
std::optional<std::uint32_t> parse_raw(std::string_view text);

// Passes the parts of "Ladar(3/0):2" to `append`, one after the other.
template <typename Append>
void spell(const Address::Fields& fields, Append append) {
  const auto number = [&](std::uint32_t value, int base) {
    std::array<char, 10> digits{};
    const auto end = std::to_chars(digits.begin(), digits.end(), value, base).ptr;
    append(std::string_view(digits.begin(), end));
  };
  if (const std::string_view name = class_name(fields.class_id); !name.empty()) {
    append(name);
  } else {
    append("unknown[");
    number(fields.class_id, 16);
    append("]");
  }
  append("(");
  number(fields.system, 10);
  append("/");
  number(fields.instance, 10);
  append(")");
  if (fields.local == 0) return;
  append(":");
  number(fields.local, 10);
}

}  // namespace

std::string_view class_name(std::uint32_t class_id) {
  for (const auto names : {std::span<const ClassName>(kClassNames), own_names()}) {
    for (const ClassName& c : names) {
      if (c.id == class_id) return c.name;
    }
  }
  return {};
}

std::optional<std::uint32_t> class_id_of(std::string_view name) {
  // Not std::tolower: it depends on the locale.
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c; };
  const auto same = [&](char a, char b) { return lower(a) == lower(b); };
  for (const auto names : {std::span<const ClassName>(kClassNames), own_names()}) {
    for (const ClassName& c : names) {
      if (std::ranges::equal(c.name, name, same)) return c.id;
    }
  }
  return std::nullopt;
}

bool name_class(std::uint32_t class_id, std::string_view name) {
  const bool taken = !class_name(class_id).empty() || class_id_of(name).has_value();
  if (taken || own.count == own.names.size()) return false;
  own.names[own.count++] = {class_id, name};
  return true;
}

std::string Address::to_string(const AddressWidths& w) const {
  std::string text;
  spell(fields(w), [&text](std::string_view part) { text += part; });
  return text;
}

std::string_view Address::write_to(std::span<char> room, const AddressWidths& w) const {
  std::size_t size = 0;
  spell(fields(w),
        [&](std::string_view part) { size += part.copy(room.data() + size, room.size() - size); });
  return {room.data(), size};
}

std::string Address::to_hex() const {
  std::string text = "0x";
  for (int shift = 28; shift >= 0; shift -= 4) {
    text += "0123456789abcdef"[raw_ >> shift & 0xF];
  }
  return text;
}

std::optional<Address> Address::parse(std::string_view text, const AddressWidths& w) {
  if (const auto raw = parse_raw(text)) return Address(*raw);
  const auto form = parse_form(text, w);
  if (!form) return std::nullopt;
  const Field local = form->local.value_or(Field{});
  if (form->system.any || form->class_id.any || form->instance.any || local.any) {
    return std::nullopt;
  }
  return of({form->system.value, form->class_id.value, form->instance.value, local.value}, w);
}

std::string Address::problem(std::string_view text, const AddressWidths& w) {
  std::string problem;
  (void)parse_form(text, w, &problem);
  return problem;
}

std::optional<AddressPattern> AddressPattern::parse(std::string_view text, const AddressWidths& w) {
  AddressPattern pattern;
  if (text == "*") return pattern;
  if (const auto raw = parse_raw(text)) {
    pattern.mask_ = ~std::uint32_t{0};
    pattern.value_ = *raw;
    return pattern;
  }
  const auto form = parse_form(text, w);
  if (!form) return std::nullopt;
  const Field local = form->local.value_or(Field{.any = true});
  const auto bits = [](const Field& f) { return f.any ? 0 : ~std::uint32_t{0}; };
  pattern.mask_ =
      Address::of({bits(form->system), bits(form->class_id), bits(form->instance), bits(local)}, w)
          .raw();
  pattern.value_ =
      Address::of({form->system.value, form->class_id.value, form->instance.value, local.value}, w)
          .raw();
  return pattern;
}

namespace {

std::optional<std::uint32_t> parse_number(std::string_view text, int base = 10) {
  std::uint32_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value, base);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::optional<std::uint32_t> parse_raw(std::string_view text) {
  if (text.starts_with("0x") || text.starts_with("0X")) return parse_number(text.substr(2), 16);
  return parse_number(text);
}

bool fits(std::uint32_t value, std::uint8_t bits) { return value >> bits == 0; }

// The first problem is kept.
void note(std::string* problem, const std::string& text) {
  if (problem != nullptr && problem->empty()) *problem = text;
}

void note_range(std::string* problem, std::string_view field, std::string_view value,
                std::uint8_t bits) {
  if (problem == nullptr) return;
  note(problem, std::string(field) + " " + std::string(value) + " is out of range: 0 to " +
                    std::to_string((std::uint64_t{1} << bits) - 1) +
                    " with the address widths of this fleet");
}

std::optional<Field> parse_field(std::string_view text, std::uint8_t bits, std::string_view name,
                                 std::string* problem) {
  if (text == "*") return Field{.any = true};
  const auto value = parse_number(text);
  if (!value) return std::nullopt;
  if (!fits(*value, bits)) {
    note_range(problem, name, text, bits);
    return std::nullopt;
  }
  return Field{.value = *value};
}

// "Ladar", "unknown[ff]" or "*".
std::optional<Field> parse_class(std::string_view text, std::uint8_t bits, std::string* problem) {
  constexpr std::string_view kUnknown = "unknown[";
  if (text == "*") return Field{.any = true};
  std::optional<std::uint32_t> id;
  if (text.starts_with(kUnknown) && text.ends_with(']')) {
    id = parse_number(text.substr(kUnknown.size(), text.size() - kUnknown.size() - 1), 16);
  } else {
    id = class_id_of(text);
    if (!id && !text.empty()) note(problem, "no class is called " + std::string(text));
  }
  if (!id) return std::nullopt;
  if (!fits(*id, bits)) {
    note_range(problem, "class", std::to_string(*id), bits);
    return std::nullopt;
  }
  return Field{.value = *id};
}

// Cuts `text` after the first `mark` and returns the part before it.
std::optional<std::string_view> cut(std::string_view& text, char mark) {
  const std::size_t at = text.find(mark);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view before = text.substr(0, at);
  text.remove_prefix(at + 1);
  return before;
}

std::optional<Form> parse_form(std::string_view text, const AddressWidths& w,
                               std::string* problem) {
  const auto class_text = cut(text, '(');
  const auto system_text = cut(text, '/');
  const auto instance_text = cut(text, ')');
  if (!class_text || !system_text || !instance_text) return std::nullopt;
  const auto class_id = parse_class(*class_text, w.class_id, problem);
  const auto system = parse_field(*system_text, w.system, "system", problem);
  const auto instance = parse_field(*instance_text, w.instance, "instance", problem);
  if (!class_id || !system || !instance) return std::nullopt;
  Form form{*system, *class_id, *instance, std::nullopt};
  if (text.empty()) return form;
  if (!text.starts_with(':')) return std::nullopt;
  form.local = parse_field(text.substr(1), w.local, "local id", problem);
  if (!form.local) return std::nullopt;
  return form;
}

}  // namespace
}  // namespace tims
