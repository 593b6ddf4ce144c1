// Decides which routers may connect: the handling of HELLO.
//
// Nothing is stored, looked up or sent at length for a sender whose address is unverified: the
// first HELLO is answered with a cookie (RETRY), and only a HELLO that returns the cookie proves
// its source address. Then the configuration decides whether this router links with the sender.
// Of two routers with the same system and id, the linked one stays as long as it proves that it
// is running.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>

#include "router/core/random.h"
#include "router/core/router.h"
#include "router/link/datagram.h"
#include "router/link/link.h"
#include "tims/time.h"

namespace tims::link {

class Admission {
 public:
  Admission(core::Router& router, const Identity& self, const core::SipKey& secret)
      : router_(router), self_(self), secret_(secret) {}

  // Empty when both sides have a protocol version in common.
  [[nodiscard]] static std::optional<Refuse> version_refusal(const Hello& hello);
  // "Tims(1/1) robot1" followed by `what`.
  [[nodiscard]] Refuse refusal(const Hello& hello, RefuseCode code, std::string_view what) const;

  // True when the sender has received what was sent to its address a moment ago; otherwise it is
  // asked to repeat the HELLO.
  // `epoch`: 0 in the sealed version, where it is not known yet.
  [[nodiscard]] bool is_proven(Time now, const NetAddress& from, std::uint64_t token,
                               std::uint64_t epoch, std::uint64_t given) const;
  [[nodiscard]] Retry retry(Time now, const NetAddress& from, std::uint64_t token,
                            std::uint64_t epoch) const {
    return {token, cookie(from, token, epoch, now.time_since_epoch())};
  }

  // The setting under which this router may connect; null otherwise, with the reason in `refuse`.
  // `is_called`: for settings that connect, whether this side calls that router.
  using IsCalled = std::function<bool(const LinkSettings&)>;
  [[nodiscard]] const LinkSettings* accepting(std::span<const LinkSettings> settings,
                                              const NetAddress& from, const Hello& hello,
                                              const IsCalled& is_called, Refuse& refuse) const;

  // kWait: the linked router is given time to prove that it is running.
  enum class Rival : std::uint8_t { kNone, kWait, kRefuse };
  [[nodiscard]] Rival rival(Time now, const NetAddress& from, const Hello& hello, const Link& link,
                            Refuse& refuse);
  void forget_rivals(const Identity& identity) { conflicts_.erase(identity.address().raw()); }

  // For the event log; rate-limited.
  void note_refused(Time now, const NetAddress& from, const Identity& who, std::string_view why);

 private:
  [[nodiscard]] std::uint64_t cookie(const NetAddress& from, std::uint64_t token,
                                     std::uint64_t epoch, Duration period) const;
  // False when a router at this address was named in the event log a moment ago, or too many others
  // were.
  bool may_note(Time now, const NetAddress& from);

  core::Router& router_;
  const Identity self_;
  const core::SipKey secret_;
  // Router address -> time of the first rival HELLO.
  std::unordered_map<std::uint32_t, Time> conflicts_;
  std::map<NetAddress, Time> noted_;  // time of the last log entry
};

}  // namespace tims::link
