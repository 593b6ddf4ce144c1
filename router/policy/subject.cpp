#include "router/policy/subject.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "base/text.h"

namespace tims::policy {
namespace {

constexpr std::array<std::string_view, 11> kKinds{
    kind::kRouter, kind::kSystem, kind::kRole,  kind::kUser, kind::kRight, kind::kUid,
    kind::kGid,    kind::kUnit,   kind::kLabel, kind::kNet,  kind::kPort};
constexpr std::array<std::string_view, 3> kRoles{"subsystem", "system", "top"};
constexpr std::array<std::string_view, 3> kRights{"look", "drive", "configure"};
constexpr std::array<std::string_view, 4> kPorts{"local", "tcp", "websocket", "link"};

struct Parts {
  std::string_view kind;
  std::string_view value;
};

Parts parts_of(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return {text, {}};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

// An address of the internet, IPv4 as ::ffff:a.b.c.d. Parsed here, since policy makes no system
// calls.
using Bits = std::array<std::uint8_t, 16>;

bool parse_v4(std::string_view text, std::uint8_t* to) {
  for (int i = 0; i < 4; ++i) {
    const std::size_t dot = i < 3 ? text.find('.') : text.size();
    if (dot == std::string_view::npos) return false;
    const auto number = base::parse_number<std::uint8_t>(text.substr(0, dot));
    if (!number) return false;
    to[i] = *number;
    text.remove_prefix(std::min(text.size(), dot + 1));
  }
  return text.empty();
}

// Groups of four hex digits; "::" stands once for as many zeros as are missing.
bool parse_groups(std::string_view text, std::vector<std::uint8_t>& bytes) {
  while (!text.empty()) {
    const std::size_t colon = std::min(text.find(':'), text.size());
    const auto group = base::parse_number<std::uint16_t>(text.substr(0, colon), 16);
    if (!group || colon > 4) return false;
    bytes.push_back(static_cast<std::uint8_t>(*group >> 8));
    bytes.push_back(static_cast<std::uint8_t>(*group & 0xFF));
    if (colon + 1 == text.size()) return false;
    text.remove_prefix(std::min(text.size(), colon + 1));
  }
  return bytes.size() <= 16;
}

std::optional<Bits> parse_address(std::string_view text) {
  Bits bits{};
  if (text.starts_with("::ffff:") && text.find('.') != std::string_view::npos)
    text.remove_prefix(7);
  if (text.find(':') == std::string_view::npos) {
    bits[10] = bits[11] = 0xFF;
    return parse_v4(text, bits.data() + 12) ? std::optional(bits) : std::nullopt;
  }
  text = text.substr(0, text.find('%'));
  const std::size_t gap = text.find("::");
  std::vector<std::uint8_t> head;
  std::vector<std::uint8_t> tail;
  if (!parse_groups(text.substr(0, gap), head)) return std::nullopt;
  if (gap == std::string_view::npos) {
    if (head.size() != 16) return std::nullopt;
  } else if (!parse_groups(text.substr(gap + 2), tail) || head.size() + tail.size() > 14) {
    return std::nullopt;
  }
  std::ranges::copy(head, bits.begin());
  std::ranges::copy(tail, bits.end() - static_cast<std::ptrdiff_t>(tail.size()));
  return bits;
}

struct Net {
  Bits bits{};
  unsigned length = 128;
};

std::optional<Net> parse_net(std::string_view text) {
  const std::size_t slash = text.find('/');
  const auto bits = parse_address(text.substr(0, slash));
  if (!bits) return std::nullopt;
  const bool is_v4 = text.find(':') == std::string_view::npos;
  Net net{*bits, 128};
  if (slash == std::string_view::npos) return net;
  const auto length = base::parse_number<unsigned>(text.substr(slash + 1));
  if (!length || *length > (is_v4 ? 32U : 128U)) return std::nullopt;
  net.length = *length + (is_v4 ? 96 : 0);
  return net;
}

bool contains(const Net& net, const Bits& bits) {
  for (unsigned i = 0; i < net.length; ++i) {
    const auto bit = static_cast<std::uint8_t>(0x80U >> (i % 8));
    if ((net.bits[i / 8] & bit) != (bits[i / 8] & bit)) return false;
  }
  return true;
}

template <std::size_t size>
std::string one_of(std::string_view kind, std::string_view value,
                   const std::array<std::string_view, size>& known) {
  if (value == "*" || std::ranges::find(known, value) != known.end()) return {};
  std::string text = "\"" + std::string(value) + "\" is no " + std::string(kind) + ": write ";
  for (std::size_t i = 0; i < size; ++i)
    text.append(i == 0 ? "" : i + 1 == size ? " or " : ", ").append(known[i]);
  return text;
}

std::string problem_of_value(std::string_view kind, std::string_view value) {
  if (kind == kind::kRole) return one_of("role", value, kRoles);
  if (kind == kind::kRight) return one_of("right", value, kRights);
  if (kind == kind::kPort) return one_of("port", value, kPorts);
  if (kind == kind::kNet)
    return value == "*" || parse_net(value)
               ? ""
               : "\"" + std::string(value) + "\" is no network: write net:10.9.0.0/16";
  const bool is_number = kind == kind::kUid || kind == kind::kGid || kind == kind::kSystem;
  if (is_number && value != "*" && !base::parse_number<std::uint32_t>(value))
    return std::string(kind) + ":" + std::string(value) + " must be a number, such as " +
           std::string(kind) + ":3";
  const std::size_t star = value.find('*');
  if (star != std::string_view::npos && star + 1 != value.size())
    return "\"*\" may stand only at the end of " + std::string(kind) + ":" + std::string(value);
  return {};
}

}  // namespace

Subject& Subject::add(std::string_view kind, std::string_view value) {
  std::string identity = std::string(kind) + ":" + std::string(value);
  if (name.empty()) name = identity;
  identities.push_back(std::move(identity));
  return *this;
}

Subject& Subject::add(std::string_view kind, std::uint64_t value) {
  return add(kind, std::to_string(value));
}

Subject& Subject::add_own() {
  if (name.empty()) name = kind::kOwn;
  identities.emplace_back(kind::kOwn);
  return *this;
}

bool Subject::has(std::string_view identity) const {
  return std::ranges::find(identities, identity) != identities.end();
}

std::optional<Subject> Subject::parse(std::string_view text) {
  Subject subject;
  while (!text.empty()) {
    const std::string_view item = base::trimmed(text.substr(0, text.find(',')));
    text.remove_prefix(std::min(text.size(), text.find(',')));
    if (!text.empty()) text.remove_prefix(1);
    const Parts parts = parts_of(item);
    if (!SubjectPattern::problem(item).empty() || item.find('*') != std::string_view::npos)
      return std::nullopt;
    if (item == kind::kOwn)
      subject.add_own();
    else
      subject.add(parts.kind, parts.value);
    const bool is_router =
        parts.kind == kind::kRouter || parts.kind == kind::kSystem || parts.kind == kind::kRole;
    if (is_router && !subject.is_router()) subject.add(kind::kPort, "link");
  }
  return subject.identities.empty() ? std::nullopt : std::optional(subject);
}

std::string SubjectPattern::problem(std::string_view text) {
  if (text == "*" || text == kind::kOwn) return {};
  const Parts parts = parts_of(text);
  if (std::ranges::find(kKinds, parts.kind) == kKinds.end()) {
    std::vector<std::string_view> known(kKinds.begin(), kKinds.end());
    known.push_back(kind::kOwn);
    std::string what = "\"" + std::string(text) + "\" is no subject";
    if (const auto near = base::nearest(parts.kind, known))
      return what + "; did you mean " + std::string(*near) + (*near == kind::kOwn ? "?" : ":...?");
    return what +
           ": write \"*\", \"own\", or one such as \"uid:1000\", \"user:guest\", "
           "\"router:base\", \"net:10.9.0.0/16\"";
  }
  if (parts.value.empty())
    return "\"" + std::string(text) + "\" needs a value: write " + std::string(parts.kind) + ":...";
  return problem_of_value(parts.kind, parts.value);
}

std::optional<SubjectPattern> SubjectPattern::parse(std::string_view text) {
  if (!problem(text).empty()) return std::nullopt;
  SubjectPattern pattern;
  pattern.text_ = text;
  return pattern;
}

bool SubjectPattern::names_routers() const {
  const std::string_view kind = parts_of(text_).kind;
  return kind == kind::kRouter || kind == kind::kSystem || kind == kind::kRole ||
         text_ == "port:link";
}

bool SubjectPattern::matches(const Subject& subject) const {
  if (subject.is_router() && !names_routers()) return false;
  if (text_ == "*") return true;
  const Parts own = parts_of(text_);
  const bool glob = text_.ends_with('*');
  const std::string_view beginning = std::string_view(text_).substr(0, text_.size() - 1);
  return std::ranges::any_of(subject.identities, [&](const std::string& identity) {
    if (glob) return identity.starts_with(beginning);
    if (own.kind != kind::kNet) return identity == text_;
    const Parts parts = parts_of(identity);
    return parts.kind == kind::kNet && is_in_net(parts.value, own.value);
  });
}

bool SubjectPattern::covers(const SubjectPattern& other) const {
  if (text_ == other.text_) return true;
  if (text_ == "*") return !other.names_routers();
  const Parts own = parts_of(text_);
  const Parts its = parts_of(other.text_);
  if (own.kind != its.kind || own.value.empty()) return false;
  if (text_.ends_with('*'))
    return other.text_.starts_with(std::string_view(text_).substr(0, text_.size() - 1));
  if (own.kind != kind::kNet) return false;
  const auto wide = parse_net(own.value);
  const auto narrow = parse_net(its.value);
  return wide && narrow && wide->length <= narrow->length && contains(*wide, narrow->bits);
}

bool is_in_net(std::string_view address, std::string_view net) {
  const auto bits = parse_address(address);
  const auto parsed = parse_net(net);
  return bits && parsed && contains(*parsed, *bits);
}

}  // namespace tims::policy
