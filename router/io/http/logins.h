// Who may use this port from a browser or a program beyond this host: one-time tokens, and the
// sessions that they begin. Pure; kept in memory only, so a restart ends all sessions.
//
//   token    made for somebody who is known already (timsctl web); works once, for 60 s
//   session  a cookie or a bearer; ends 12 h after its last use
//
// Both are 128 random bits, written as 32 hex digits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "router/io/rights.h"
#include "tims/time.h"

namespace tims::io {

class Logins {
 public:
  static constexpr Duration kTokenTime = std::chrono::seconds(60);
  static constexpr Duration kIdleTime = std::chrono::hours(12);
  // Beyond these numbers, the one that ends next ends at once.
  static constexpr std::size_t kTokensMax = 64;
  static constexpr std::size_t kSessionsMax = 256;

  // `random` fills with bytes that nobody can predict.
  explicit Logins(std::function<void(std::span<std::byte>)> random) : random_(std::move(random)) {}

  std::string offer(Time now, Person person);  // a token
  std::string begin(Time now, Person person);  // a session
  // A session for a token, which is used up. Empty: there is no such token (any more).
  std::optional<std::string> redeem(Time now, std::string_view token);
  // Whose session it is, used now. Null: there is no such session. Valid until the next call.
  const Person* use(Time now, std::string_view session);
  void end(std::string_view session);
  // Ends what was given to these people.
  void end_if(const std::function<bool(const Person&)>& whom);

  [[nodiscard]] std::size_t sessions() const { return sessions_.size(); }

 private:
  struct Entry {
    std::string secret;
    Person person;
    Time ends{};
  };
  using Entries = std::vector<Entry>;

  std::string add(Entries& entries, std::size_t most, Time ends, Person person);
  static Entries::iterator find(Entries& entries, std::string_view secret, Time now);

  std::function<void(std::span<std::byte>)> random_;
  Entries tokens_;
  Entries sessions_;
};

}  // namespace tims::io
