// Who sends: what a port knows about the client that connects, and what rules are written for.
//
// A port gives a Subject when it connects a client (ClientInfo::subject). Its identities are texts
// of the form "kind:value"; a rule names such texts ("uid:1000", "unit:laser.service", "net:
// 10.9.0.0/16", "user:*"). What was proven by a certificate or a login has the kinds router,
// system, role, user, right; the kernel proves uid, gid, unit, label; net is no proof, only an
// address.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tims::policy {

// The kinds of identities, and two without a value. "own": a program of the router's own user, or
// of root, on the router's host. "other-robot": at a router with keys, a router of another robot at
// a link below or beside.
namespace kind {
inline constexpr std::string_view kOwn = "own";
inline constexpr std::string_view kOtherRobot = "other-robot";
inline constexpr std::string_view kRouter = "router";  // name of a router at the end of a link
inline constexpr std::string_view kSystem = "system";  // its system
inline constexpr std::string_view kRole = "role";      // subsystem, system, top
inline constexpr std::string_view kUser = "user";      // of a certificate or a login
inline constexpr std::string_view kRight = "right";    // of such a user: look, drive, configure
inline constexpr std::string_view kUid = "uid";
inline constexpr std::string_view kGid = "gid";
inline constexpr std::string_view kUnit = "unit";    // systemd unit: "laser.service"
inline constexpr std::string_view kLabel = "label";  // of a security module, such as AppArmor
inline constexpr std::string_view kNet = "net";      // address of the other host; weak
inline constexpr std::string_view kPort = "port";    // local, tcp, websocket, link
}  // namespace kind

struct Subject {
  // Identifies it in reports; all connections with this name share their rates. The strongest of
  // its identities: "user:guest", "router:base", "uid:1000", "net:10.9.1.7".
  std::string name;
  std::vector<std::string> identities;

  // Adds "kind:value"; the first one added is its name.
  Subject& add(std::string_view kind, std::string_view value);
  Subject& add(std::string_view kind, std::uint64_t value);
  Subject& add_own() { return add_word(kind::kOwn); }
  Subject& add_other_robot() { return add_word(kind::kOtherRobot); }
  [[nodiscard]] bool has(std::string_view identity) const;
  // A router at the end of a link. Only rules that name routers, systems or roles apply to it.
  [[nodiscard]] bool is_router() const { return has("port:link"); }
  // From a text such as "user:guest" or "uid:1000, gid:100": for tests of rules. Empty: wrong.
  static std::optional<Subject> parse(std::string_view text);

  bool operator==(const Subject&) const = default;

 private:
  Subject& add_word(std::string_view word);
};

// What a rule says about subjects: "uid:1000", "user:*", "unit:rack-*", "net:10.9.0.0/16", "own",
// "*".
class SubjectPattern {
 public:
  // The problem of a text, for users; empty: it is a pattern.
  static std::string problem(std::string_view text);
  static std::optional<SubjectPattern> parse(std::string_view text);

  [[nodiscard]] bool matches(const Subject& subject) const;
  // True when it matches every subject that the other one matches. False negatives are possible.
  [[nodiscard]] bool covers(const SubjectPattern& other) const;
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  [[nodiscard]] bool names_routers() const;

  std::string text_;
};

}  // namespace tims::policy
