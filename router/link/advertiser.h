// The mailboxes that two linked routers advertise to each other: what we say (all that is below us,
// the router's exported table) and what we hold of theirs.
//
// Neither side keeps a queue of changes for the other. A table is numbered by its changes and has a
// hash; who comes up says what it still holds (WANT), and hears what has changed since that number,
// or everything when too much has. The keep-alives carry number and hash on, so that both sides can
// compare at any time: a link that comes back, or a message that was lost with a restarted router,
// never leaves a table wrong for longer than a few of them. (BGP says a change once and trusts the
// session; we compare as OSPF does with its database descriptions.)
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "router/core/router.h"
#include "router/link/frame.h"
#include "router/link/link_session.h"

namespace tims::link {

class Advertiser {
 public:
  Advertiser(core::Router& router, LinkSession& session) : router_(router), session_(session) {}

  // The link is up. `imports`: we want the other side's table.
  void begin(Time now, core::ClientId client, bool imports);
  // More than this is not taken of the other side's table. What was left is asked for again when
  // there is room.
  void set_mailboxes_max(std::uint32_t max) { mailboxes_max_ = max; }
  // The link is down; what we held is withdrawn with the client.
  void end();

  // A super router that is not used is told nothing. One that was used until now hears for a while
  // that we are farther away than we are: those above prefer the other way, and what is on its way
  // through this one finds us still.
  enum class Scope : std::uint8_t { kNothing, kAsFarther, kAll };
  void set_scope(Time now, Scope scope);
  // Tells what has changed. Cheap when nothing has.
  void advertise(Time now);

  // From the control lane. False: it is none of these messages.
  bool on_control(Time now, const core::Message& message);
  // What the keep-alive says of the other side's table: asks again when ours is different. False:
  // it was asked so often that the lane itself must be damaged; only a new session mends that.
  [[nodiscard]] bool compare(Time now, const TableState& theirs);
  // For our keep-alive.
  [[nodiscard]] TableState advertised() const { return wanted_ ? advertised_ : kNobodyAsked; }
  [[nodiscard]] std::uint64_t held() const { return held_count_; }
  // Announced and not taken, so far: too many, or of a system that the link is not for.
  [[nodiscard]] std::uint64_t refused() const { return refused_count_; }

 private:
  // Says the keep-alive of a router that does not know what the other one holds: no table is 0
  // with this hash.
  static constexpr TableState kNobodyAsked{0, 1};

  void send(Time now, ControlMessage& message);
  void want(Time now, const TableState& state);
  [[nodiscard]] std::optional<TableState> to_ask_for(Time now, const TableState& theirs) const;
  void advertise_all(Time now);
  void advertise_table(Time now);
  void advertise_changes(Time now);
  void done(Time now);
  void add(Time now, Address address, core::Origin origin);
  void remove(Time now, Address address);
  void leave_out(Time now, Address address);
  void note(Time now, core::EventKind kind, Address address);
  [[nodiscard]] std::optional<core::Origin> held(Address address) const;
  void forget_all(Time now);

  core::Router& router_;
  LinkSession& session_;
  core::ClientId client_{};
  bool imports_ = false;

  Scope scope_ = Scope::kAll;
  bool wanted_ = false;      // the other side has said what it holds
  TableState advertised_{};  // what it will hold when all has arrived

  TableState holding_{};    // the last DONE
  std::uint32_t hash_ = 0;  // of what we hold
  std::uint64_t held_count_ = 0;
  Time asked_{};  // last WANT
  int asked_in_vain_ = 0;
  Time heard_{};  // last word about the other side's table
  // What the router did not take: it goes round in a loop, or is not the link's to bring. Counts as
  // held, or we would ask for ever.
  std::map<std::uint32_t, core::Origin> refused_;
  std::uint32_t mailboxes_max_ = 0;
  std::uint64_t refused_count_ = 0;
  bool incomplete_ = false;  // there were more: what we hold is not what the other side told
  Time next_note_{};
};

}  // namespace tims::link
