// The mailboxes that two linked routers announce to each other: our announcements (the router's
// exported table: everything below this router) and our copy of the other side's.
//
// Neither side queues changes for the other. A table is numbered by its changes and has a hash. A
// side that comes up sends the state it still holds (WANT) and receives the changes since that
// number, or the whole table when there were too many. Keep-alives carry number and hash, so both
// sides can compare at any time: after a lost link, or a message lost by a restart, a table is
// never wrong for longer than a few keep-alives. (BGP announces a change once and relies on the
// session; this protocol compares, as OSPF does with its database descriptions.)
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "router/core/router.h"
#include "router/link/frame.h"
#include "router/link/handover.h"
#include "router/link/link_session.h"

namespace tims::link {

class Advertiser {
 public:
  Advertiser(core::Router& router, LinkSession& session) : router_(router), session_(session) {}

  // The link is up. `imports`: this side wants the other side's table.
  void begin(Time now, core::ClientId client, bool imports);
  // Upper bound on imported mailboxes. The rest is requested again when there is room.
  void set_mailboxes_max(std::uint32_t max) { mailboxes_max_ = max; }
  // For the next router (handover.h). restore() is in place of begin(); false: no such state.
  void save(StateWriter& to, std::uint32_t table_number) const;
  [[nodiscard]] bool restore(Time now, core::ClientId client, bool imports, StateReader& from);
  // The link is down; imported mailboxes are withdrawn with the client.
  void end();

  // Scope of announcements. A super router that is not in use receives none. One that was in use
  // until now receives, for a while, larger distances: routers above then prefer the
  // other route, while messages already in transit through this one still arrive.
  enum class Scope : std::uint8_t { kNothing, kAsFarther, kAll };
  void set_scope(Time now, Scope scope);
  // Announces changes. Cheap when there are none.
  void advertise(Time now);

  // A message from the control lane. Returns false when it is not one of these messages.
  bool on_control(Time now, const core::Message& message);
  // Compares with the table state in the other side's keep-alive, and requests the table again
  // when ours differs. Returns false after so many requests in vain that the lane itself must be
  // damaged; only a new session repairs that. A request that may not have arrived is not in vain:
  // the other side may be heard over a path that works in one direction only.
  [[nodiscard]] bool compare(Time now, const TableState& theirs);
  // For our keep-alive.
  [[nodiscard]] TableState advertised() const { return wanted_ ? advertised_ : kNotRequested; }
  [[nodiscard]] std::uint64_t held() const { return held_count_; }
  // Number of announcements refused so far: too many, or of a system that the link is not for.
  [[nodiscard]] std::uint64_t refused() const { return refused_count_; }

 private:
  // State sent in the keep-alive by a router that does not know what the other side holds. No
  // table has number 0 with this hash.
  static constexpr TableState kNotRequested{0, 1};

  void send(Time now, ControlMessage& message);
  void request(Time now, const TableState& state);
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
  bool wanted_ = false;      // the other side has sent WANT
  TableState advertised_{};  // state the other side will have when everything has arrived

  TableState holding_{};    // state of the last DONE
  std::uint32_t hash_ = 0;  // hash of what we hold
  std::uint64_t held_count_ = 0;
  Time asked_{};  // time of the last WANT
  int asked_in_vain_ = 0;
  Time last_message_{};  // time of the last message about the other side's table
  // Announcements that the router refused: in a loop, or of a system the link is not for. Counted
  // as held, otherwise they would be requested forever.
  std::map<std::uint32_t, core::Origin> refused_;
  std::uint32_t mailboxes_max_ = 0;
  std::uint64_t refused_count_ = 0;
  bool incomplete_ = false;  // the limit was reached: we hold less than the other side announced
  Time next_note_{};
};

}  // namespace tims::link
