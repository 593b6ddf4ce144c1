// Who may connect: what becomes of a router that says HELLO.
//
// Nothing is kept, looked up or said at length for somebody who may not be there: the first HELLO
// is answered with a cookie (RETRY), and the one that brings it back was sent from where it says.
// Then the configuration decides whom this router links with; and of two routers that say they have
// the same system and id, the one that is linked stays, as long as it shows that it lives.
#pragma once

#include <functional>
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

  // Nothing: we have a version of the protocol in common.
  [[nodiscard]] static std::optional<Refuse> version_refusal(const Hello& hello);
  // "Tims(1/1) robot1" and what is behind it.
  [[nodiscard]] Refuse refusal(const Hello& hello, RefuseCode code, std::string_view what) const;

  // Whoever says it has received what was sent to its address a moment ago; else it is asked to say
  // it again.
  [[nodiscard]] bool is_proven(Time now, const NetAddress& from, const Hello& hello) const;
  [[nodiscard]] Retry retry(Time now, const NetAddress& from, const Hello& hello) const {
    return {hello.token, cookie(from, hello, now.time_since_epoch())};
  }

  // The setting under which this router may connect; else `refuse` says why not. `is_called`: with
  // settings that connect, whether we call this router.
  using IsCalled = std::function<bool(const LinkSettings&)>;
  [[nodiscard]] const LinkSettings* accepting(std::span<const LinkSettings> settings,
                                              const NetAddress& from, const Hello& hello,
                                              const IsCalled& is_called, Refuse& refuse) const;

  // kWait: the one that is linked is given time to show that it lives.
  enum class Rival : std::uint8_t { kNone, kWait, kRefuse };
  [[nodiscard]] Rival rival(Time now, const NetAddress& from, const Hello& hello, const Link& link,
                            Refuse& refuse);
  void forget_rivals(const Identity& who) { conflicts_.erase(who.address().raw()); }

  // For the event log; not each time.
  void note_refused(Time now, const NetAddress& from, const Hello& hello, const Refuse& refuse);

 private:
  [[nodiscard]] std::uint64_t cookie(const NetAddress& from, const Hello& hello,
                                     Duration period) const;

  core::Router& router_;
  const Identity self_;
  const core::SipKey secret_;
  std::unordered_map<std::uint32_t, Time> conflicts_;  // router address -> first rival HELLO
  std::unordered_map<std::uint32_t, Time> refused_;    // router address -> when it was noted
};

}  // namespace tims::link
