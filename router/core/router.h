// The router's decisions: which clients are connected, which client owns which mailbox, and where
// each message goes. It also defines the interfaces to its surroundings: the ports, which carry
// out its decisions, and the program around it.
//
// Pure: time and bytes come in as arguments, actions go out through its ports. Forwarding a
// message does not allocate; connecting and registering do.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "router/core/driving_leases.h"
#include "router/core/legacy.h"
#include "router/core/newest_values.h"
#include "router/core/policy_gate.h"
#include "router/core/registrations.h"
#include "router/core/routes.h"
#include "router/core/statistics.h"
#include "router/core/stream_counters.h"
#include "router/core/types.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

struct Receiver {
  ClientId client{};
  PortKind port = PortKind::kTcp;
  std::uint32_t token = 0;   // the port's own number for this client (ClientInfo::token)
  std::uint32_t handle = 0;  // the port's own number for this mailbox (register_mailbox)
};

// A port: where clients of one kind attach. It feeds the router (Router::connect, on_message,
// ...) and carries out the router's decisions. Except for flush(), none of these functions may
// call the router.
class Port : public Interface {
 public:
  // The bytes stay valid until the ports are flushed at the end of the turn. The returned outcome
  // is counted: kDelivered, kMailboxFull, kMailboxReplaced, kTooBig, kQueueFull, kClientGone or
  // kOwnerGone.
  virtual Outcome deliver(Time now, const Receiver& to, const Message& message) = 0;

  // A message without a body that the router itself created (lifesign, answer to a command,
  // NOT_AVAILABLE). `to.handle` is 0 when it goes to the connection and not to a mailbox.
  virtual void reply(Time now, const Receiver& to, const Header& header) = 0;

  // The router has already removed this client and its mailboxes: close its connection.
  virtual void close(const Receiver& client, CloseReason reason) = 0;

  // From now on, of the samples of a stream (flag STREAM) that wait for this client, only the
  // newest is kept. It gets messages with all flags, and its streams are counted.
  virtual void keep_newest(const Receiver& /*client*/) {}
  // Null: the client does not keep the newest only.
  [[nodiscard]] virtual const StreamCounters* streams(std::uint32_t /*token*/) const {
    return nullptr;
  }

  // Clients of this port that send to this mailbox directly must send through the router from now
  // on.
  virtual void moved(Address) {}

  // Completes what deliver() and reply() began since the last flush: bytes go into sockets or
  // queues, sleeping receivers are woken. Afterwards, delivered bytes are no longer needed. May
  // call the router (losses, disconnected clients). Called after every batch; cheap when there is
  // nothing to do.
  virtual void flush(Time) {}

  // Bytes queued for a client that reads slowly.
  [[nodiscard]] virtual std::uint64_t queued_bytes(std::uint32_t /*token*/) const { return 0; }

  // Called before the router exits: accept no new clients. drained() then reports whether all
  // output has been written.
  virtual void stop_accepting() {}
  [[nodiscard]] virtual bool drained() const { return true; }
};

// The program around the router. None of these functions may call the router.
class RouterHooks : public Interface {
 public:
  // A question to the router. Answered with Router::answer(), now or later.
  virtual void admin(Time now, ClientId from, const Message& request) = 0;

  // A TCP or WebSocket client sends a question to another router. Returns false when it is not
  // permitted; the question is then passed to admin(), which refuses it.
  virtual bool may_ask(ClientId /*from*/, const Message& /*request*/) { return true; }

  // What a question to a router needs.
  virtual policy::Right right_of(const Message& /*request*/) { return policy::Right::kLook; }
  // A program of this host whose user writes the rules: root, or that of the router.
  virtual bool writes_rules(const ClientInfo& /*client*/) { return false; }
  // The policy denies a question to a router: to be answered with the rule, like admin().
  virtual void deny_admin(ClientId /*from*/, const Message& /*request*/,
                          std::string_view /*rule*/) {}
  // The policy denies a message with flag TRACE.
  virtual void trace_denied(ClientId /*from*/, const Message& /*message*/,
                            std::string_view /*rule*/) {}

  // A message with flag TRACE is about to be forwarded from one client to another.
  virtual void traced(ClientId from, ClientId to, const Message& message) = 0;

  // An event was added to the event log.
  virtual void event(const Event& event) = 0;
};

struct RouterSettings {
  Address address{};  // this router's address: Tims(system/id)
  AddressWidths widths{};
  PriorityClasses classes{};
  Role role = Role::kSystem;
  std::uint32_t epoch = 0;     // lower half of the epoch chosen at start
  bool compat_delete = false;  // any TCP client may delete any TCP client's mailbox
  Duration lifesign_interval = std::chrono::seconds(5);
  std::uint32_t clients_max = 1024;  // see Router::has_room()
  std::uint32_t mailboxes_per_client_max = 4096;
};

// So many of the events that are audited are kept.
inline constexpr std::size_t kAuditEvents = 1024;

// Maximum number of clients of one router that may own the sink of texts at the same time.
inline constexpr std::size_t kTextReadersMax = 16;

struct Registration {
  enum class Status : std::uint8_t { kOk, kAddressInUse, kTooMany, kNoSuchClient };
  Status status = Status::kOk;
  ClientId owner{};  // kAddressInUse: the current owner; kNoClient means the router itself
};

// kUnknown: the address is not registered.
enum class Removal : std::uint8_t { kOk, kUnknown, kNotOwner };

class Router {
 public:
  Router(const RouterSettings& settings, HashSeed seed, RouterHooks& hooks);
  Router(const Router&) = delete;
  Router& operator=(const Router&) = delete;

  // Must be called before traffic starts. A port that is switched off is not attached and has no
  // clients.
  void attach(PortKind kind, Port& port) { ports_[static_cast<std::size_t>(kind)] = &port; }
  // Called at the end of every turn, and whenever delivered bytes are about to become invalid.
  void flush(Time now);
  void stop_accepting();
  [[nodiscard]] bool drained() const;  // true when all ports are drained
  [[nodiscard]] std::uint64_t queued_bytes(PortKind kind, std::uint32_t token) const;
  [[nodiscard]] const StreamCounters* streams(PortKind kind, std::uint32_t token) const;

  // From now on, values of messages are kept there.
  void keep_newest(NewestValues& values) { newest_ = &values; }
  // Null: none are kept.
  [[nodiscard]] const NewestValues* newest() const { return newest_; }

  // From now on, messages of clients are judged by this policy. Precondition: no client is
  // connected.
  void judge_by(policy::Enforcer& enforcer) { gate_.use(enforcer); }
  // Null: everything may be sent.
  [[nodiscard]] const policy::Enforcer* policy() const { return gate_.enforcer(); }
  // Local programs that could do everything, and may no longer write to mailboxes of others
  // directly, are disconnected; they connect again by themselves.
  void set_policy(Time now, policy::Policy policy);
  // Whether programs of this host may write to this mailbox directly: neither its owner is judged,
  // nor does it take driving commands of a robot that somebody has the driving lease of.
  [[nodiscard]] bool is_direct(const Table::Entry& entry) const;

  // Changes who drives a robot. `holder`: the robot, the holder's name, mailbox and stick.
  LeaseResult change_lease(Time now, ClientId from, LeaseVerb verb, const DrivingLease& holder);
  [[nodiscard]] const DrivingLeases& leases() const { return leases_; }

  // Changes the settings of a running router. The address does not change.
  void configure(Time now, const RouterSettings& settings);

  // Returns kNoClient when there is no room: the port must close the connection.
  ClientId connect(Time now, const ClientInfo& info);
  // A quarter of clients_max is reserved for programs of this host, and browsers can have at most
  // another quarter, so that clients of one port do not lock out others. Links are counted and
  // bounded by the code that creates them.
  [[nodiscard]] bool has_room(PortKind port) const;
  // Records a client that a port itself had to refuse.
  void refuse(Time now, const ClientInfo& info, CloseReason reason);
  // Withdraws its mailboxes. Does nothing when the router has already removed the client.
  void disconnect(Time now, ClientId id, CloseReason reason);

  // For clients of this host. Announcements of links: learn().
  Registration register_mailbox(Time now, ClientId id, Address address, std::uint32_t handle = 0);
  Removal remove_mailbox(Time now, ClientId by, Address address);

  // A client sent a message. The header may be rewritten; the bytes are used until the flush.
  Outcome on_message(Time now, ClientId from, Message& message);
  // The router's answer to an admin request: to the address in it or, with dest = src = 0, to the
  // connection that sent the request.
  Outcome answer(Time now, ClientId asker, Message& message);
  // Messages for (or, with bad_length and incomplete, from) a client that a port has lost.
  void on_lost(Time now, PortKind port, ClientId client, Outcome outcome, const LossCounts& losses);
  void on_lost(Time now, PortKind port, ClientId client, Outcome outcome, std::uint8_t priority,
               std::uint64_t size);

  // A client that had fallen behind has read some of its queue. It counts as running, although
  // the lifesign may not have reached it yet.
  void on_progress(ClientId id);

  // --- Links: clients with PortKind::kLink, whose mailboxes are behind another router.

  // The other router has another certificate: rules and static routes know it by this name and
  // subject from now on.
  void rename_link(Time now, ClientId link, std::string_view name, const policy::Subject& subject);

  // Sets the link for messages to unknown destinations; kNoClient: none.
  void set_uplink(Time now, ClientId link);
  // The link announces a mailbox. `origin.hops` is counted from this router. Returns false when
  // the announcement is refused because it is in a loop.
  bool learn(Time now, ClientId link, Address address, const Origin& origin);
  void forget(Time now, ClientId link, Address address);
  void forget_all(Time now, ClientId link);
  // Whether announcements of the link wait for their address.
  [[nodiscard]] bool has_waiting(ClientId link) const { return registrations_.has_waiting(link); }
  // The link's current announcement of this address, whether the link owns it or waits for it.
  [[nodiscard]] std::optional<Origin> announced(ClientId link, Address address) const;
  // A message that was handed to a link, and that the link has lost or dropped.
  void on_undelivered(Time now, ClientId link, const Header& header, Outcome outcome);
  // Events of links that are not about a message: counted and logged.
  void note(const Event& event) { happened(event); }
  void set_static_routes(std::vector<StaticRoute> routes) { routes_.set_static(std::move(routes)); }
  [[nodiscard]] const Routes& routes() const { return routes_; }

  // The table announced to routers above and beside: all mailboxes below this router and its own.
  [[nodiscard]] const ExportedTable& exported_table() const {
    return registrations_.exported_table();
  }
  // Goes on from the table of the former router, which had this number and these addresses,
  // ascending: other routers that know it need the differences only.
  void continue_table(std::uint32_t number, std::span<const Address> former);
  // Empty when the address is not below this router.
  [[nodiscard]] std::optional<Origin> exported(Address address) const;
  template <typename Visit>  // (Address, const Origin&)
  void for_each_exported(Visit visit) const {
    visit(settings_.address, registrations_.here());
    table().for_each([&](const Table::Entry& entry) {
      if (const auto origin = exported(entry.address)) visit(entry.address, *origin);
    });
  }
  [[nodiscard]] Origin origin(const Table::Entry& entry) const {
    return registrations_.origin(*clients_.find(entry.owner), entry);
  }

  // Routers that a link announced before it went down, and that no other link has announced
  // since.
  [[nodiscard]] const MissingRouters& missing() const { return missing_; }

  [[nodiscard]] Address text_sink() const { return settings_.classes.texts; }
  // True when more than one client owns the sink of texts: each receives every text.
  [[nodiscard]] bool shares_texts() const { return !text_readers_.empty(); }

  // Call on_timeout at or after next_timeout(); kNever while there is nothing to do.
  [[nodiscard]] Time next_timeout() const {
    const Time next = std::min(lifesigns_.next_beat(), leases_.next_end());
    return policy() == nullptr ? next : std::min(next, policy()->next_report());
  }
  void on_timeout(Time now);

  // Read access. An entry is valid until mailboxes are added or removed.
  [[nodiscard]] const Table::Entry* find(Address address) const {
    return registrations_.find(address);
  }
  [[nodiscard]] const Client* client(ClientId id) const { return clients_.find(id); }
  [[nodiscard]] const Clients& clients() const { return clients_; }
  [[nodiscard]] const Table& table() const { return registrations_.table(); }
  [[nodiscard]] const AddressSet& addresses() const { return registrations_.addresses(); }
  [[nodiscard]] const EventLog& events() const { return events_; }
  [[nodiscard]] const EventLog& audit() const { return audit_; }  // is_audited()
  [[nodiscard]] const MessageCounters& messages() const { return messages_; }
  [[nodiscard]] const EventCounters& event_counts() const { return event_counts_; }
  [[nodiscard]] const DropHistory& drops() const { return drops_; }
  [[nodiscard]] const RouterSettings& settings() const { return settings_; }

 private:
  // Only attached ports have clients.
  [[nodiscard]] Port& port_of(const Receiver& to) {
    return *ports_[static_cast<std::size_t>(to.port)];
  }
  Outcome dispatch(Time now, Client& sender, Message& message);
  // The port's number for a mailbox of the client; empty when the mailbox belongs to another
  // client.
  [[nodiscard]] std::optional<std::uint32_t> handle_of(const Client& owner, Address address) const;
  [[nodiscard]] bool names_own_mailbox(const Client& sender, const Message& message) const;
  [[nodiscard]] bool is_router(Address address) const;
  // Without a handle: its connection.
  static Receiver receiver_of(const Client& client, std::uint32_t handle = 0);
  Outcome forward(Time now, Client* from, Message& message);
  void copy_text(Time now, Message& message);
  [[nodiscard]] NextHop local_text_reader(const NextHop& otherwise) const;
  Outcome hand_over(Time now, const Receiver& to, Client& receiver, Message& message);
  Outcome for_router_itself(Time now, Client& sender, std::uint32_t handle, const Message& message);
  void answer_not_available(Time now, const Receiver& to, const Header& request);
  static void count_dropped(Client* receiver, const Count& count);

  // --- other routers
  void learn_again(Time now, Address address);
  [[nodiscard]] std::vector<Address> routers_behind(const Client& link) const;
  void miss(Time now, const Client& link, const std::vector<Address>& routers);
  void duplicate(Time now, const Client& link, Address address, const Origin& origin);
  [[nodiscard]] Peer peer_router(const Client& link, const Origin& origin) const;
  Outcome stop_loop(Time now, const Client* from, const Client& to, const Message& message);

  // --- policy
  // Empty: it passes.
  std::optional<Outcome> judge(Time now, Client& sender, std::uint32_t handle, Message& message);
  void report_denials(Time now);

  // --- driving leases
  void guard_driven(std::uint32_t robot);
  Outcome refuse_to_drive(Time now, Client& sender, std::uint32_t handle, const Message& message,
                          const DrivingLease& lease);
  void ended(Time now, const std::vector<DrivingLeases::Ended>& leases);

  // --- commands of the original protocol
  bool carry_out_registration(Time now, Client& sender, const LegacyCommand& command);
  Outcome carry_out(Time now, Client& sender, Message& message);
  void send_widths(Time now, Client& client, Message& login);
  [[nodiscard]] bool may_delete(const Client& by, const Client& owner) const;
  void answer_command(Time now, const Client& client, const Header& request, bool success);
  void ask_for_lifesign(Time now, const Client& client);
  void give_up(Time now, Client& client, CloseReason reason);

  void withdraw_all(Time now, Client& client);
  void withdrawn(Time now, Address address, const Peer& owner);
  // The sink of texts can have several owners: the first is in the table, the others in a
  // separate list.
  [[nodiscard]] bool may_share(const Client& client, Address address) const;
  bool stop_sharing(ClientId client);
  void next_text_reader(Time now);
  void record_end(Time now, const Client& client, CloseReason reason);
  void happened(Time now, EventKind kind, Address address, const Peer& client,
                const Peer& owner = {});
  void happened(const Event& event);
  void count(EventKind kind) { event_counts_.add(kind); }
  [[nodiscard]] Peer peer(ClientId id) const;

  RouterSettings settings_;
  RouterHooks& hooks_;
  std::array<Port*, kPortKindCount> ports_{};
  Time next_loop_event_{};
  Time next_refusal_event_{};
  struct TextReader {
    ClientId client{};
    std::uint32_t handle = 0;
  };
  std::vector<TextReader> text_readers_;  // all but the first, which is in the table
  Clients clients_;
  Registrations registrations_;
  Routes routes_;
  MissingRouters missing_;
  NewestValues* newest_ = nullptr;
  DrivingLeases leases_;
  PolicyGate gate_;
  Lifesigns lifesigns_;
  MessageCounters messages_;
  EventCounters event_counts_;
  DropHistory drops_;
  EventLog events_;
  EventLog audit_{kAuditEvents};
};

}  // namespace tims::core
