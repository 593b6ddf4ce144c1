// The router's decisions: who is connected, who owns which mailbox, where does this message go; and
// what it asks of its surroundings: ports, which carry out what it decides, and the program around
// it.
//
// Pure: time and bytes come in as arguments, actions go out through its ports. Nothing is allocated
// on a message's way; connecting and registering allocate.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "router/core/legacy.h"
#include "router/core/registrations.h"
#include "router/core/statistics.h"
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

// A port: where clients of one kind attach. It feeds the router (Router::connect, on_message, ...)
// and carries out what that decides. But for flush(), none of these may call the router.
class Port : public Interface {
 public:
  // The bytes stay valid until the ports are flushed at the end of the turn. What is answered is
  // counted: kDelivered, kMailboxFull, kMailboxReplaced, kTooBig, kQueueFull, kClientGone or
  // kOwnerGone.
  virtual Outcome deliver(Time now, const Receiver& to, const Message& message) = 0;

  // A message without a body that the router itself made (lifesign, answer to a command,
  // NOT_AVAILABLE). `to.handle` is 0 when it goes to the connection and not to a mailbox.
  virtual void reply(Time now, const Receiver& to, const Header& header) = 0;

  // The router has already forgotten this client and its mailboxes: end its connection.
  virtual void close(const Receiver& client, CloseReason reason) = 0;

  // Its clients, if they send to this mailbox by themselves, must come by the router from now on.
  virtual void moved(Address) {}

  // Ends what deliver() and reply() began since the last flush: bytes go into sockets or queues,
  // sleeping receivers are woken. After this, delivered bytes are no longer needed. May call the
  // router (losses, disconnected clients). Called after every batch; cheap when nothing is to do.
  virtual void flush(Time) {}

  // What waits for a client that reads slowly.
  [[nodiscard]] virtual std::uint64_t queued_bytes(std::uint32_t /*token*/) const { return 0; }

  // Before the router ends: no new clients; and is there nothing left to be written?
  virtual void stop_accepting() {}
  [[nodiscard]] virtual bool drained() const { return true; }
};

// The program around the router. Nothing here may call back into the router.
class RouterHooks : public Interface {
 public:
  // A question to the router. Answered with Router::answer(), now or later.
  virtual void admin(Time now, ClientId from, const Message& request) = 0;

  // A client of TCP or of a WebSocket asks another router. False: it may not; admin() gets the
  // question and refuses it.
  virtual bool may_ask(ClientId /*from*/, const Message& /*request*/) { return true; }

  // A message with flag TRACE is about to go from one client to another.
  virtual void traced(ClientId from, ClientId to, const Message& message) = 0;

  // Something happened that is kept in the event log.
  virtual void event(const Event& event) = 0;
};

struct RouterSettings {
  Address address{};  // the router's own: Tims(system/id)
  AddressWidths widths{};
  PriorityClasses classes{};
  Role role = Role::kSystem;
  std::uint32_t epoch = 0;     // lower half of what was drawn at start
  bool compat_delete = false;  // any TCP client may delete any TCP client's mailbox
  Duration lifesign_interval = std::chrono::seconds(5);
  std::uint32_t clients_max = 1024;  // see Router::has_room()
  std::uint32_t mailboxes_per_client_max = 4096;
};

// Clients of one router that may have the sink of texts at a time.
inline constexpr std::size_t kTextReadersMax = 16;

// Where messages go whose destination nobody has registered.
struct StaticRoute {
  AddressPattern match{};
  Text<63> text{};  // the pattern as it was written
  Text<63> via{};   // name of a router at the other end of a link
};

struct Registration {
  enum class Status : std::uint8_t { kOk, kAddressInUse, kTooMany, kNoSuchClient };
  Status status = Status::kOk;
  ClientId owner{};  // kAddressInUse: who has it; kNoClient means the router itself
};

// kUnknown: nobody has registered the address.
enum class Removal : std::uint8_t { kOk, kUnknown, kNotOwner };

class Router {
 public:
  Router(const RouterSettings& settings, HashSeed seed, RouterHooks& hooks);

  // Set up before traffic starts. A port that is switched off is not attached, and has no clients.
  void attach(PortKind kind, Port& port) { ports_[static_cast<std::size_t>(kind)] = &port; }
  // At the end of every turn, and whenever delivered bytes are not to be needed any more.
  void flush(Time now);
  void stop_accepting();
  [[nodiscard]] bool drained() const;  // of all ports
  [[nodiscard]] std::uint64_t queued_bytes(PortKind kind, std::uint32_t token) const;

  // Settings of a running router. The address stays.
  void configure(Time now, const RouterSettings& settings);

  // Without room for it, kNoClient: the port closes the connection.
  ClientId connect(Time now, const ClientInfo& info);
  // A quarter of clients_max is kept for programs of this host, another quarter is all that
  // browsers can have, so that guests of one port do not shut out others. Links are counted and
  // bounded by those who make them.
  [[nodiscard]] bool has_room(PortKind port) const;
  // A client that a port had to turn away itself.
  void refuse(Time now, const ClientInfo& info, CloseReason reason);
  // Withdraws its mailboxes. Nothing happens when the router has given the client up itself.
  void disconnect(Time now, ClientId id, CloseReason reason);

  // Of a client of this host. What links announce: learn().
  Registration register_mailbox(Time now, ClientId id, Address address, std::uint32_t handle = 0);
  Removal remove_mailbox(Time now, ClientId by, Address address);

  // A client sent something. The header may be rewritten; the bytes are used until the flush.
  Outcome on_message(Time now, ClientId from, Message& message);
  // The router's answer to an admin request: to the address in it, or, with dest = src = 0, to
  // the connection of the one who asked.
  Outcome answer(Time now, ClientId asker, Message& message);
  // Messages for (or, with bad_length and incomplete, from) a client that a port has lost.
  void on_lost(Time now, PortKind port, ClientId client, Outcome outcome, const LossCounts& losses);
  void on_lost(Time now, PortKind port, ClientId client, Outcome outcome, std::uint8_t priority,
               std::uint64_t size);

  // A client that had fallen behind has read something of what waits for it. It lives, although the
  // lifesign may not have reached it yet.
  void on_progress(ClientId id);

  // --- Links: clients with PortKind::kLink, whose mailboxes live behind another router.

  // Where unknown destinations go; kNoClient: nowhere.
  void set_uplink(Time now, ClientId link);
  [[nodiscard]] ClientId uplink() const { return uplink_; }
  // The link announces a mailbox. `origin`: with the hops from here.
  // False: not taken, it goes round in a loop.
  bool learn(Time now, ClientId link, Address address, const Origin& origin);
  void forget(Time now, ClientId link, Address address);
  void forget_all(Time now, ClientId link);
  // What the link has announced of it, whether it owns it or waits for it.
  [[nodiscard]] std::optional<Origin> announced(ClientId link, Address address) const;
  // Is it of the system the link is for, or does a static route lead there over it? Of a mailbox
  // that the link announces, and of the source of a message it brings.
  [[nodiscard]] bool may_come_from(const Client& link, Address address) const;
  // A message that was handed to a link, and that the link has lost or given up.
  void on_undelivered(Time now, ClientId link, const Header& header, Outcome outcome);
  // Links have things to tell that are no message's: counted and kept.
  void note(const Event& event) { happened(event); }
  void set_static_routes(std::vector<StaticRoute> routes) { static_routes_ = std::move(routes); }
  [[nodiscard]] const std::vector<StaticRoute>& static_routes() const { return static_routes_; }

  // What is told to routers above and beside: all that is below this one, itself included.
  [[nodiscard]] const ExportedTable& exported_table() const {
    return registrations_.exported_table();
  }
  // Nothing: the address is not below.
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

  // The client a message to this address is handed to; `from` is null for the router itself.
  struct NextHop {
    Client* to = nullptr;
    std::uint32_t handle = 0;
    enum class By : std::uint8_t { kTable, kStatic, kSystem, kUp, kNone } by = By::kNone;
    Outcome why_not = Outcome::kNoRoute;  // without `to`
  };
  [[nodiscard]] NextHop next_hop(const Client* from, Address dest) const;

  // Those that links announced until they went down, and that no other link has brought since.
  [[nodiscard]] const MissingRouters& missing() const { return missing_; }

  // Whether more than one client has the sink of texts: each gets every text.
  [[nodiscard]] bool shares_texts() const { return !text_readers_.empty(); }

  // Call on_timeout at or after next_timeout(); kNever while there is nothing to do.
  [[nodiscard]] Time next_timeout() const { return lifesigns_.next_beat(); }
  void on_timeout(Time now);

  // To look at. An entry is valid until mailboxes come or go.
  [[nodiscard]] const Table::Entry* find(Address address) const {
    return registrations_.find(address);
  }
  [[nodiscard]] const Client* client(ClientId id) const { return clients_.find(id); }
  [[nodiscard]] const Clients& clients() const { return clients_; }
  [[nodiscard]] const Table& table() const { return registrations_.table(); }
  [[nodiscard]] const AddressSet& addresses() const { return registrations_.addresses(); }
  [[nodiscard]] const EventLog& events() const { return events_; }
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
  // The port's number for a mailbox of the client's; nothing: it is somebody else's.
  [[nodiscard]] std::optional<std::uint32_t> handle_of(const Client& owner, Address address) const;
  [[nodiscard]] bool is_router(Address address) const;
  // Without a handle: its connection.
  static Receiver receiver_of(const Client& client, std::uint32_t handle = 0);
  Outcome forward(Time now, Client* from, Message& message);
  void copy_text(Time now, Message& message);
  [[nodiscard]] NextHop who_keeps_texts(const NextHop& otherwise) const;
  Outcome hand_over(Time now, const Receiver& to, Client& receiver, Message& message);
  Outcome for_router_itself(Time now, Client& sender, std::uint32_t handle, const Message& message);
  void answer_not_available(Time now, const Receiver& to, const Header& request);
  static void count_dropped(Client* receiver, const Count& count);

  // --- other routers
  [[nodiscard]] ClientId link_named(std::string_view name) const;
  [[nodiscard]] ClientId peer_router(std::uint32_t system) const;
  void learn_again(Time now, Address address);
  [[nodiscard]] std::vector<Address> routers_behind(const Client& link) const;
  void miss(Time now, const Client& link, const std::vector<Address>& routers);
  void duplicate(Time now, const Client& link, Address address, const Origin& origin);
  [[nodiscard]] Peer peer_router(const Client& link, const Origin& origin) const;
  [[nodiscard]] bool leads_over_link(const Client& from, Address dest) const;
  Outcome stop_loop(Time now, const Client* from, const Client& to, const Message& message);

  // --- the original's commands
  Outcome carry_out(Time now, Client& sender, Message& message);
  void tell_widths(Time now, Client& client, Message& login);
  [[nodiscard]] bool may_delete(const Client& by, const Client& owner) const;
  void answer_command(Time now, const Client& client, const Header& request, bool success);
  void ask_for_lifesign(Time now, const Client& client);
  void give_up(Time now, Client& client, CloseReason reason);

  void withdraw_all(Time now, Client& client);
  void withdrawn(Time now, Address address, const Peer& owner);
  // The sink of texts, which several may have: the first as any mailbox, the others beside it.
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
  ClientId uplink_{};
  std::vector<ClientId> links_;
  std::vector<StaticRoute> static_routes_;
  Time next_loop_event_{};
  struct TextReader {
    ClientId client{};
    std::uint32_t handle = 0;
  };
  std::vector<TextReader> text_readers_;  // but for the first, who is in the table
  Clients clients_;
  Registrations registrations_;
  MissingRouters missing_;
  Lifesigns lifesigns_;
  MessageCounters messages_;
  EventCounters event_counts_;
  DropHistory drops_;
  EventLog events_;
};

}  // namespace tims::core
