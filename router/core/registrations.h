// Mailboxes and their owners: keeps the table, the clients' own lists and what is told to the
// routers above in step.
//
// A mailbox behind a link may be announced by several links: by two ways to the same router, of
// which the shorter is used, or by two routers that both claim it, of which the first has it. The
// others wait here and are looked at when the owner is gone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "router/core/address_set.h"
#include "router/core/below.h"
#include "router/core/clients.h"
#include "router/core/origins.h"
#include "router/core/table.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

class Registrations {
 public:
  explicit Registrations(HashSeed seed) : table_(seed) {}

  [[nodiscard]] const Table::Entry* find(Address address) const { return table_.find(address); }
  [[nodiscard]] const Table& table() const { return table_; }
  [[nodiscard]] const AddressSet& addresses() const { return addresses_; }  // of the table
  [[nodiscard]] const Below& below() const { return below_; }
  Below& below() { return below_; }

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
  Below below_;
  std::multimap<std::uint32_t, Waiting> waiting_;
};

}  // namespace tims::core
