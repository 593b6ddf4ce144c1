#include "router/core/registrations.h"

namespace tims::core {

void Registrations::add(Time now, Client& owner, Address address, std::uint32_t handle) {
  const auto since = std::chrono::floor<std::chrono::seconds>(now.time_since_epoch());
  table_.insert({.address = address,
                 .owner = owner.id,
                 .handle = handle,
                 .position = static_cast<std::uint32_t>(owner.mailboxes.size())});
  owner.mailboxes.push_back(
      {.address = address, .registered_s = static_cast<std::uint32_t>(since.count())});
}

void Registrations::remove(Client& owner, Address address) {
  const Table::Entry* entry = table_.find(address);
  // The last of the list takes the place of the one that goes.
  const std::uint32_t position = entry->position;
  table_.erase(entry);
  const OwnedMailbox last = owner.mailboxes.back();
  owner.mailboxes.pop_back();
  if (last.address == address) return;
  owner.mailboxes[position] = last;
  table_.find(last.address)->position = position;
}

Address Registrations::remove_last(Client& owner) {
  const Address address = owner.mailboxes.back().address;
  owner.mailboxes.pop_back();
  table_.erase(table_.find(address));
  return address;
}

}  // namespace tims::core
