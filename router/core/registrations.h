// Who is connected (Clients), and which mailbox belongs to whom: the table and what is kept in step
// with it (Registrations), the routers that mailboxes behind links live at (Origins), what this
// router tells those above and beside it (ExportedTable), and the routers that went with their link
// (MissingRouters).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "router/core/statistics.h"
#include "router/core/table.h"
#include "router/core/types.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

// --- clients

// What a port says about a new client.
struct ClientInfo {
  PortKind port = PortKind::kTcp;
  std::uint32_t token = 0;  // the port's own number for it, handed back with every delivery
  std::uint32_t pid = 0;    // 0: not known
  std::uint32_t uid = 0;
  Text<31> name{};
  Text<55> endpoint{};  // "127.0.0.1:54321"
  struct Link {         // of another router
    LinkKind kind = LinkKind::kSub;
    Role role = Role::kSubsystem;
    std::uint8_t system = 0;
    Address router{};
    std::optional<std::uint8_t> only{};  // nothing but this system comes from it; nothing: any
  } link{};
  bool lifesign = false;  // is asked whether it lives from the start, as original clients are
};

struct OwnedMailbox {
  Address address{};
  std::uint32_t registered_s = 0;  // on the monotonic clock
};

struct Client {
  ClientId id{};
  ClientInfo info{};
  Time connected_at{};
  std::vector<OwnedMailbox> mailboxes{};  // in no order
  bool watched = false;                   // gets lifesigns
  bool owes_answer = false;               // to the last one
  Count in{};                             // from it
  Count out{};                            // to it: taken by its mailbox, connection or queue
  Count dropped{};                        // to it, and lost

  [[nodiscard]] Peer peer() const {
    return {
        .id = id, .port = info.port, .pid = info.pid, .name = info.name, .endpoint = info.endpoint};
  }
};

// A client's slot is its number modulo the number of slots; numbers whose slot is taken are left
// out. So a number leads to its client with one look, and an old number to nobody.
class Clients {
 public:
  Clients() : slots_(kSlotsMin) {}

  Client& add(const ClientInfo& info, Time now);
  void remove(ClientId id);

  [[nodiscard]] Client* find(ClientId id) const {
    Client* client = slots_[id.value & (slots_.size() - 1)].get();
    return client != nullptr && client->id == id ? client : nullptr;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t size(PortKind port) const {
    return sizes_[static_cast<std::size_t>(port)];
  }

  // `visit` may remove the client it is given.
  template <typename Visit>
  void for_each(Visit visit) const {
    for (const auto& slot : slots_) {
      if (slot) visit(*slot);
    }
  }

 private:
  static constexpr std::size_t kSlotsMin = 64;  // a power of two, as every later size

  void grow();
  std::unique_ptr<Client>& slot(ClientId id) { return slots_[id.value & (slots_.size() - 1)]; }

  std::vector<std::unique_ptr<Client>> slots_;  // at most half of them taken
  std::size_t size_ = 0;
  std::array<std::size_t, kPortKindCount> sizes_{};
  ClientId last_{};
};

// --- mailboxes

// The routers that mailboxes behind links live at: a short list with numbers, so that a mailbox
// needs no more than one of them.
class Origins {
 public:
  // A number for this origin, held until release().
  std::uint32_t hold(const Origin& origin) {
    const auto [place, added] = numbers_.try_emplace(key(origin), 0);
    if (added) {
      if (free_.empty()) {
        place->second = static_cast<std::uint32_t>(list_.size());
        list_.emplace_back();
      } else {
        place->second = free_.back();
        free_.pop_back();
      }
      list_[place->second] = {origin, 0};
    }
    ++list_[place->second].held;
    return place->second;
  }
  void release(std::uint32_t number) {
    Item& item = list_[number];
    if (--item.held > 0) return;
    numbers_.erase(key(item.origin));
    free_.push_back(number);
  }
  [[nodiscard]] const Origin& at(std::uint32_t number) const { return list_[number].origin; }
  [[nodiscard]] std::size_t size() const { return numbers_.size(); }

 private:
  using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint8_t>;
  struct Item {
    Origin origin{};
    std::uint32_t held = 0;
  };
  static Key key(const Origin& o) { return {o.router.raw(), o.epoch, o.hops}; }

  std::map<Key, std::uint32_t> numbers_;
  std::vector<Item> list_;
  std::vector<std::uint32_t> free_;
};

// One mailbox's part in the hash over a table, which is the exclusive or of all of them. `hops` as
// the router that tells counts them.
std::uint32_t table_hash(Address address, const Origin& origin);

// What this router tells the routers above and beside it: every mailbox below it, and each change
// of that, numbered. A neighbour that knows number n is told what has changed since; one that is
// too far behind, everything. So nothing is ever queued for a slow neighbour.
class ExportedTable {
 public:
  static constexpr std::uint32_t kRemembered = 8192;  // changes

  ExportedTable() : changed_(std::make_unique<std::array<Address, kRemembered>>()) {}

  void added(Address address, const Origin& origin) {
    hash_ ^= table_hash(address, origin);
    ++size_;
    note(address);
  }
  void removed(Address address, const Origin& origin) {
    hash_ ^= table_hash(address, origin);
    --size_;
    note(address);
  }

  [[nodiscard]] std::uint32_t number() const { return number_; }  // of the newest change
  [[nodiscard]] std::uint32_t hash() const { return hash_; }
  [[nodiscard]] std::uint32_t size() const { return size_; }
  // Can the changes after number `n` be told?
  [[nodiscard]] bool remembers(std::uint32_t n) const { return number_ - n <= kRemembered; }
  // What change number `n` was about; remembers(n - 1).
  [[nodiscard]] Address changed(std::uint32_t n) const { return (*changed_)[n % kRemembered]; }

 private:
  void note(Address address) { (*changed_)[++number_ % kRemembered] = address; }

  std::uint32_t number_ = 0;
  std::uint32_t hash_ = 0;
  std::uint32_t size_ = 0;
  std::unique_ptr<std::array<Address, kRemembered>> changed_;
};

// When there are more, the oldest go.
inline constexpr std::size_t kMissingRoutersMax = 1024;
// Who has not come back in this time is not expected any more.
inline constexpr Duration kMissingRouterKept = std::chrono::minutes(10);

struct MissingRouter {
  std::uint64_t number = 0;  // counts up: the place in a list that is read in pages
  Address router{};
  Address behind{};  // the router at the other end of the link; may be this one itself
  Text<31> via{};    // and its name
  Time since{};
};

// The routers that went with the link they were behind: who knows the fleet shall see that they are
// missing. Nothing is routed by it.
class MissingRouters {
 public:
  // In the order of time. It is none of them yet.
  void add(MissingRouter missing);
  // It is there again, behind whatever link.
  void found(Address router);
  template <typename Visit>  // (const MissingRouter&), the oldest first
  void for_each(Time now, Visit visit) const {
    for (const MissingRouter& missing : list_)
      if (now < missing.since + kMissingRouterKept) visit(missing);
  }

 private:
  std::deque<MissingRouter> list_;
  std::uint64_t numbers_ = 0;
};

// Mailboxes and their owners: keeps the table, the clients' own lists and what is told to the
// routers above in step.
//
// A mailbox behind a link may be announced by several links: by two ways to the same router, of
// which the shorter is used, or by two routers that both claim it, of which the first has it. The
// others wait here and are looked at when the owner is gone.
class Registrations {
 public:
  explicit Registrations(HashSeed seed) : table_(seed) {}

  [[nodiscard]] const Table::Entry* find(Address address) const { return table_.find(address); }
  [[nodiscard]] const Table& table() const { return table_; }
  [[nodiscard]] const AddressSet& addresses() const { return addresses_; }  // of the table
  [[nodiscard]] const ExportedTable& exported_table() const { return exported_; }
  ExportedTable& exported_table() { return exported_; }

  // Nobody owns the address. A client's mailbox, with its port's number for it; or one behind a
  // link, with the router it lives at.
  void add(Time now, Client& owner, Address address, std::uint32_t handle);
  void add(Time now, Client& link, Address address, const Origin& origin);
  // It is one of the owner's.
  void remove(Client& owner, Address address);
  // The owner's last one; it has at least one. All of them go in time proportional to their number.
  Address remove_last(Client& owner);

  // Where a mailbox lives; `here` for those of this host.
  [[nodiscard]] Origin origin(const Client& owner, const Table::Entry& entry) const;
  void set_here(const Origin& here) { here_ = here; }
  [[nodiscard]] const Origin& here() const { return here_; }

  // Those that wait for an address to become free, in the order they came.
  struct Waiting {
    ClientId link{};
    Origin origin{};
  };
  void wait(Address address, const Waiting& waiting) { waiting_.emplace(address.raw(), waiting); }
  bool stop_waiting(Address address, ClientId link);
  void stop_waiting(ClientId link);
  // The one with the fewest hops; it waits no longer.
  std::optional<Waiting> take_waiting(Address address);
  [[nodiscard]] std::optional<Origin> waiting_origin(Address address, ClientId link) const;
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

 private:
  void insert(Time now, Client& owner, Address address, std::uint32_t number);
  void withdraw(const Client& owner, const Table::Entry& entry);

  Table table_;
  AddressSet addresses_;
  Origins origins_;
  Origin here_{};
  ExportedTable exported_;
  std::multimap<std::uint32_t, Waiting> waiting_;
};

}  // namespace tims::core
