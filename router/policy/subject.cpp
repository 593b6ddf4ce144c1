#include "router/policy/subject.h"

#include <algorithm>
#include <array>

#include "base/ip_network.h"
#include "base/text.h"

namespace tims::policy {
namespace {

constexpr std::array<std::string_view, 11> kKinds{
    kind::kRouter, kind::kSystem, kind::kRole,  kind::kUser, kind::kRight, kind::kUid,
    kind::kGid,    kind::kUnit,   kind::kLabel, kind::kNet,  kind::kPort};
constexpr std::array<std::string_view, 2> kWithoutValue{kind::kOwn, kind::kOtherRobot};
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

// Identities without a value.
bool is_word(std::string_view text) {
  return std::ranges::find(kWithoutValue, text) != kWithoutValue.end();
}

// Only routers at the other ends of links have such identities.
bool is_of_routers(std::string_view kind) {
  return kind == kind::kRouter || kind == kind::kSystem || kind == kind::kRole ||
         kind == kind::kOtherRobot;
}

// Without the scope of an address: "%eth0".
std::optional<base::IpNetwork> network_of(std::string_view value) {
  if (value.find('/') == std::string_view::npos) value = value.substr(0, value.find('%'));
  return base::IpNetwork::parse(value);
}

bool is_in(const std::optional<base::IpNetwork>& narrow,
           const std::optional<base::IpNetwork>& wide) {
  return wide && narrow && wide->contains(*narrow);
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
    return value == "*" || network_of(value)
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

Subject& Subject::add_word(std::string_view word) {
  if (name.empty()) name = word;
  identities.emplace_back(word);
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
    if (is_word(item))
      subject.add_word(item);
    else
      subject.add(parts.kind, parts.value);
    if (is_of_routers(parts.kind) && !subject.is_router()) subject.add(kind::kPort, "link");
  }
  return subject.identities.empty() ? std::nullopt : std::optional(subject);
}

std::string SubjectPattern::problem(std::string_view text) {
  if (text == "*" || is_word(text)) return {};
  const Parts parts = parts_of(text);
  if (std::ranges::find(kKinds, parts.kind) == kKinds.end()) {
    std::vector<std::string_view> known(kKinds.begin(), kKinds.end());
    known.insert(known.end(), kWithoutValue.begin(), kWithoutValue.end());
    std::string what = "\"" + std::string(text) + "\" is no subject";
    if (const auto near = base::nearest(parts.kind, known))
      return what + "; did you mean " + std::string(*near) + (is_word(*near) ? "?" : ":...?");
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
  return is_of_routers(parts_of(text_).kind) || text_ == "port:link";
}

bool SubjectPattern::matches(const Subject& subject) const {
  if (subject.is_router() && !names_routers()) return false;
  if (text_ == "*") return true;
  const Parts own = parts_of(text_);
  const auto net = own.kind == kind::kNet ? network_of(own.value) : std::nullopt;
  const bool glob = text_.ends_with('*');
  const std::string_view beginning = std::string_view(text_).substr(0, text_.size() - 1);
  return std::ranges::any_of(subject.identities, [&](const std::string& identity) {
    if (glob) return identity.starts_with(beginning);
    if (own.kind != kind::kNet) return identity == text_;
    const Parts parts = parts_of(identity);
    return parts.kind == kind::kNet && is_in(network_of(parts.value), net);
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
  return own.kind == kind::kNet && is_in(network_of(its.value), network_of(own.value));
}

}  // namespace tims::policy
