// The connected clients (Clients), and the owner of each mailbox: the table and the data kept
// consistent with it (Registrations), the routers that own mailboxes behind links (Origins), the
// table this router announces to routers above and beside it (ExportedTable), and the routers
// that were lost with their link (MissingRouters).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "router/core/statistics.h"
#include "router/core/table.h"
#include "router/core/types.h"
#include "router/policy/enforcer.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

// --- clients

// What a port knows about a new client.
struct ClientInfo {
  PortKind port = PortKind::kTcp;
  std::uint32_t token = 0;  // the port's own number for it, returned with every delivery
  std::uint32_t pid = 0;    // 0: not known
  std::uint32_t uid = 0;
  Text<32> name{};
  Text<56> endpoint{};  // "127.0.0.1:54321"
  struct Link {         // data of a link to another router
    // By which rules and static routes know it. With keys, its certificate names it.
    Text<64> name{};
    LinkKind kind = LinkKind::kSub;
    Role role = Role::kSubsystem;
    std::uint16_t system = 0;
    Address router{};
    std::optional<std::uint16_t> only{};  // accept only addresses of this system; empty: of any
  } link{};
  bool lifesign = false;      // send lifesigns from the start, as to original clients
  policy::Subject subject{};  // who it is; what it may send follows from that
};

struct OwnedMailbox {
  Address address{};
  std::uint32_t registered_s = 0;  // on the monotonic clock
};

struct Client {
  ClientId id{};
  ClientInfo info{};
  Time connected_at{};
  std::vector<OwnedMailbox> mailboxes{};  // unordered
  bool watched = false;                   // receives lifesigns
  bool owes_answer = false;               // has not answered the last lifesign
  bool keeps_newest = false;              // see Port::keep_newest()
  policy::Profile* profile = nullptr;     // what it may send; null: everything
  policy::RecentPasses recent{};          // of what it sends
  Count in{};                             // sent by it
  Count out{};                            // accepted by its mailbox, connection or queue
  Count dropped{};                        // addressed to it, and lost

  // Original programs set the extension flags arbitrarily, and do not know what they mean.
  [[nodiscard]] bool is_original() const { return info.port == PortKind::kTcp && !keeps_newest; }
  // Its messages are judged by the policy.
  [[nodiscard]] bool is_judged() const { return profile != nullptr && !profile->is_free(); }
  [[nodiscard]] Peer peer() const {
    return {
        .id = id, .port = info.port, .pid = info.pid, .name = info.name, .endpoint = info.endpoint};
  }
};

// A client's slot is its number modulo the number of slots; numbers whose slot is occupied are
// skipped. So one access finds a client by its number, and an old number finds none.
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

  // `visit` may remove the client it is called with.
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

  std::vector<std::unique_ptr<Client>> slots_;  // at most half of them occupied
  std::size_t size_ = 0;
  std::array<std::size_t, kPortKindCount> sizes_{};
  ClientId last_{};
};

// --- mailboxes

// The routers that own mailboxes behind links: a short numbered list, so that a mailbox stores
// only an index.
class Origins {
 public:
  // An index for this origin, valid until release().
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

// One mailbox's contribution to the hash of a table, which is the exclusive or of all
// contributions. `hops` as counted by the announcing router.
std::uint32_t table_hash(Address address, const Origin& origin);

// The table this router announces to the routers above and beside it: every mailbox below it,
// with each change numbered. A neighbour that has state n receives the changes since n; one that
// is too far behind receives the whole table. So nothing is ever queued for a slow neighbour.
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
  // True when all changes after number `n` are still stored.
  [[nodiscard]] bool remembers(std::uint32_t n) const {
    return number_ - n <= std::min(kRemembered, number_ - first_);
  }
  // The table goes on from that of the former router, which had this number; `changed`: the
  // addresses that are different.
  void continue_at(std::uint32_t number, std::span<const Address> changed) {
    number_ = first_ = number;
    for (const Address address : changed) note(address);
  }
  // The address that change number `n` affected. Precondition: remembers(n - 1).
  [[nodiscard]] Address changed(std::uint32_t n) const { return (*changed_)[n % kRemembered]; }

 private:
  void note(Address address) { (*changed_)[++number_ % kRemembered] = address; }

  std::uint32_t number_ = 0;
  std::uint32_t first_ = 0;  // changes up to here are not stored
  std::uint32_t hash_ = 0;
  std::uint32_t size_ = 0;
  std::unique_ptr<std::array<Address, kRemembered>> changed_;
};

// Beyond this number the oldest entries are removed.
inline constexpr std::size_t kMissingRoutersMax = 1024;
// A router that has not returned within this time is no longer expected.
inline constexpr Duration kMissingRouterKept = std::chrono::minutes(10);

struct MissingRouter {
  std::uint64_t number = 0;  // increasing; the position in a list that is read in pages
  Address router{};
  Address behind{};  // the router at the other end of the link; may be the missing router itself
  Text<32> via{};    // the name of that router
  Time since{};
};

// The routers that were lost with the link they were behind, so that operators see which routers
// are missing. Not used for routing.
class MissingRouters {
 public:
  // In order of time. Precondition: it is not in the list.
  void add(MissingRouter missing);
  // The router is reachable again, through any link.
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

// Mailboxes and their owners: keeps the table, the clients' own lists and the exported table
// consistent.
//
// Several links may announce the same mailbox: two routes to the same router, of which the
// shorter is used, or two routers that both claim the address, of which the first keeps it. The
// other announcements wait here and are considered when the owner is gone.
class Registrations {
 public:
  // `text_sink`: this address is not exported.
  Registrations(HashSeed seed, Address text_sink) : text_sink_(text_sink), table_(seed) {}

  [[nodiscard]] const Table::Entry* find(Address address) const { return table_.find(address); }
  [[nodiscard]] const Table& table() const { return table_; }
  [[nodiscard]] const AddressSet& addresses() const { return addresses_; }  // of the table
  [[nodiscard]] const ExportedTable& exported_table() const { return exported_; }
  ExportedTable& exported_table() { return exported_; }

  // Precondition: the address has no owner. Adds a client's mailbox with its port's number, or a
  // mailbox behind a link with the router that owns it.
  void add(Time now, Client& owner, Address address, std::uint32_t handle);
  void add(Time now, Client& link, Address address, const Origin& origin);
  // Precondition: the owner has it.
  void remove(Client& owner, Address address);
  // Removes the owner's last mailbox; the owner has at least one. Removing all of them takes time
  // proportional to their number.
  Address remove_last(Client& owner);

  // The router that owns a mailbox; `here` for mailboxes of this host.
  [[nodiscard]] Origin origin(const Client& owner, const Table::Entry& entry) const;
  void set_here(const Origin& here) { here_ = here; }
  [[nodiscard]] const Origin& here() const { return here_; }

  // Announcements that wait for an address to become free, in order of arrival.
  struct Waiting {
    ClientId link{};
    Origin origin{};
  };
  void wait(Address address, const Waiting& waiting) { waiting_.emplace(address.raw(), waiting); }
  bool stop_waiting(Address address, ClientId link);
  void stop_waiting(ClientId link);
  // Removes and returns the one with the fewest hops.
  std::optional<Waiting> take_waiting(Address address);
  [[nodiscard]] std::optional<Origin> waiting_origin(Address address, ClientId link) const;
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }
  [[nodiscard]] bool has_waiting(ClientId link) const {
    return std::ranges::any_of(waiting_,
                               [&](const auto& entry) { return entry.second.link == link; });
  }

 private:
  void insert(Time now, Client& owner, Address address, std::uint32_t number);
  void withdraw(const Client& owner, const Table::Entry& entry);

  [[nodiscard]] bool is_exported(const Client& owner, Address address) const;

  Address text_sink_;
  Table table_;
  AddressSet addresses_;
  Origins origins_;
  Origin here_{};
  ExportedTable exported_;
  std::multimap<std::uint32_t, Waiting> waiting_;
};

}  // namespace tims::core
