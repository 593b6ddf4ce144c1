#include "security/keys/identity.h"

#include <algorithm>
#include <array>

#include "base/text.h"

namespace tims::security {
namespace {

constexpr std::string_view kScheme = "tims://";
constexpr std::array<std::string_view, 4> kRoleNames{"subsystem", "system", "top", "user"};

// Splits at "/"; more parts than five are as wrong as five.
std::vector<std::string_view> parts_of(std::string_view text) {
  std::vector<std::string_view> parts;
  while (parts.size() < 5) {
    const std::size_t slash = text.find('/');
    parts.push_back(text.substr(0, slash));
    if (slash == std::string_view::npos) break;
    text.remove_prefix(slash + 1);
  }
  return parts;
}

std::optional<std::uint16_t> number_of(std::string_view text) {
  if (text.empty() || (text.size() > 1 && text.front() == '0')) return std::nullopt;
  return base::parse_number<std::uint16_t>(text);
}

Error wrong(std::string_view uri, std::string_view why) {
  return {Errc::kMalformed, "identity \"" + base::printable(uri) + "\": " + std::string(why)};
}

// Collects the URIs of one certificate.
class Collector {
 public:
  Result<void> add(std::string_view uri) {
    if (!uri.starts_with(kScheme)) return wrong(uri, "must begin with tims://");
    const auto parts = parts_of(uri.substr(kScheme.size()));
    if (parts.size() < 3 || parts.size() > 4) return wrong(uri, "is none of a fleet's member");
    if (!is_name(parts[0])) return wrong(uri, "the fleet's name is not allowed");
    if (!identity_.fleet.empty() && identity_.fleet != parts[0])
      return wrong(uri, "belongs to another fleet than the names before");
    identity_.fleet = parts[0];
    if (parts.size() == 4) return add_router(uri, parts);
    if (parts[1] == "name") return add_name(uri, parts[2]);
    if (parts[1] == "user") return add_user(uri, parts[2]);
    if (parts[1] == "right") return add_right(uri, parts[2]);
    return wrong(uri, "is none of a fleet's member");
  }

  Result<Identity> identity() {
    if (!has_member_) return Error(Errc::kMalformed, "the certificate names no member of a fleet");
    const bool user = identity_.role == MemberRole::kUser;
    if (user && has_name_) return Error(Errc::kMalformed, "a user with the name of a router");
    if (!user && identity_.rights != Rights())
      return Error(Errc::kMalformed, "a router with rights of a user");
    if (!user && !has_name_)
      identity_.name = usual_name(identity_.role, identity_.system, identity_.id);
    return identity_;
  }

 private:
  Result<void> add_router(std::string_view uri, const std::vector<std::string_view>& parts) {
    const auto role = role_of(parts[1]);
    const auto system = number_of(parts[2]);
    const auto id = number_of(parts[3]);
    if (!role || *role == MemberRole::kUser) return wrong(uri, "unknown role");
    if (!system || !id) return wrong(uri, "system and id are numbers from 0 to 65535");
    if (has_member_) return wrong(uri, "is a second identity");
    has_member_ = true;
    identity_.role = *role;
    identity_.system = *system;
    identity_.id = *id;
    return {};
  }

  Result<void> add_user(std::string_view uri, std::string_view text) {
    if (!is_name(text)) return wrong(uri, "the name is not allowed");
    if (has_member_) return wrong(uri, "is a second identity");
    has_member_ = true;
    identity_.role = MemberRole::kUser;
    identity_.name = text;
    return {};
  }

  Result<void> add_name(std::string_view uri, std::string_view text) {
    if (!is_name(text)) return wrong(uri, "the name is not allowed");
    if (has_name_) return wrong(uri, "is a second name");
    has_name_ = true;
    identity_.name = text;
    return {};
  }

  Result<void> add_right(std::string_view uri, std::string_view text) {
    bool* right = text == "look"        ? &identity_.rights.look
                  : text == "drive"     ? &identity_.rights.drive
                  : text == "configure" ? &identity_.rights.configure
                                        : nullptr;
    if (right == nullptr) return wrong(uri, "unknown right");
    if (*right) return wrong(uri, "is there twice");
    *right = true;
    return {};
  }

  Identity identity_;
  bool has_member_ = false;
  bool has_name_ = false;
};

}  // namespace

std::string_view name(MemberRole role) { return kRoleNames[static_cast<std::size_t>(role)]; }

std::optional<MemberRole> role_of(std::string_view text) {
  const auto* const found = std::ranges::find(kRoleNames, text);
  if (found == kRoleNames.end()) return std::nullopt;
  return static_cast<MemberRole>(found - kRoleNames.begin());
}

bool is_name(std::string_view text) {
  const auto inside = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  };
  return !text.empty() && text.size() <= 63 && inside(text.front()) && inside(text.back()) &&
         std::ranges::all_of(text,
                             [&](char c) { return inside(c) || c == '-' || c == '_' || c == '.'; });
}

std::string usual_name(MemberRole role, std::uint16_t system, std::uint16_t id) {
  if (role == MemberRole::kTop) return id <= 1 ? "base" : "base-" + std::to_string(id);
  const std::string robot = "robot" + std::to_string(system);
  return role == MemberRole::kSystem && id <= 1 ? robot : robot + "-" + std::to_string(id);
}

std::vector<std::string> Identity::uris() const {
  const std::string begin = std::string(kScheme) + fleet + "/";
  if (role != MemberRole::kUser)
    return {begin + std::string(security::name(role)) + "/" + std::to_string(system) + "/" +
                std::to_string(id),
            begin + "name/" + name};
  std::vector<std::string> all{begin + "user/" + name};
  if (rights.look) all.push_back(begin + "right/look");
  if (rights.drive) all.push_back(begin + "right/drive");
  if (rights.configure) all.push_back(begin + "right/configure");
  return all;
}

std::string Identity::to_string() const {
  if (role == MemberRole::kUser) return "user " + name;
  return std::string(security::name(role)) + " " + std::to_string(system) + ", id " +
         std::to_string(id) + " (" + name + ")";
}

Result<Identity> Identity::parse(const std::vector<std::string>& uris) {
  Collector collector;
  for (const std::string& uri : uris)
    if (auto added = collector.add(uri); !added) return added.error();
  return collector.identity();
}

}  // namespace tims::security
