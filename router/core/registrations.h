// Mailboxes and their owners: keeps the table and the clients' own lists in step.
#pragma once

#include <cstddef>
#include <cstdint>

#include "router/core/clients.h"
#include "router/core/table.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

class Registrations {
 public:
  explicit Registrations(HashSeed seed) : table_(seed) {}

  [[nodiscard]] const Table::Entry* find(Address address) const { return table_.find(address); }
  [[nodiscard]] const Table& table() const { return table_; }

  // Nobody owns the address.
  void add(Time now, Client& owner, Address address, std::uint32_t handle);
  // It is one of the owner's.
  void remove(Client& owner, Address address);
  // The owner's last one; it has at least one. All of them go in time proportional to their number.
  Address remove_last(Client& owner);

 private:
  Table table_;
};

}  // namespace tims::core
