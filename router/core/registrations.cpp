#include "router/core/registrations.h"

#include <algorithm>
#include <cassert>

namespace tims::core {
namespace {

bool is_link(const Client& owner) { return owner.info.port == PortKind::kLink; }

// Mailboxes above and beside us are not ours to tell of.
bool is_below(const Client& owner) {
  return !is_link(owner) || owner.info.link.kind == LinkKind::kSub;
}

bool is_told(const Client& owner, Address address) {
  return is_below(owner) && address != kTextSink;
}

}  // namespace

Origin Registrations::origin(const Client& owner, const Table::Entry& entry) const {
  return is_link(owner) ? origins_.at(entry.handle) : here_;
}

void Registrations::add(Time now, Client& owner, Address address, std::uint32_t handle) {
  assert(!is_link(owner));
  insert(now, owner, address, handle);
  if (is_told(owner, address)) below_.added(address, here_);
}

void Registrations::add(Time now, Client& link, Address address, const Origin& origin) {
  assert(is_link(link));
  insert(now, link, address, origins_.hold(origin));
  if (is_told(link, address)) below_.added(address, origin);
}

void Registrations::withdraw(const Client& owner, const Table::Entry& entry) {
  if (is_told(owner, entry.address)) below_.removed(entry.address, origin(owner, entry));
  if (is_link(owner)) origins_.release(entry.handle);
}

void Registrations::insert(Time now, Client& owner, Address address, std::uint32_t number) {
  const auto since = std::chrono::floor<std::chrono::seconds>(now.time_since_epoch());
  table_.insert({.address = address,
                 .owner = owner.id,
                 .handle = number,
                 .position = static_cast<std::uint32_t>(owner.mailboxes.size())});
  addresses_.insert(address);
  owner.mailboxes.push_back(
      {.address = address, .registered_s = static_cast<std::uint32_t>(since.count())});
}

void Registrations::remove(Client& owner, Address address) {
  const Table::Entry* entry = table_.find(address);
  withdraw(owner, *entry);
  // The last of the list takes the place of the one that goes.
  const std::uint32_t position = entry->position;
  table_.erase(entry);
  addresses_.erase(address);
  const OwnedMailbox last = owner.mailboxes.back();
  owner.mailboxes.pop_back();
  if (last.address == address) return;
  owner.mailboxes[position] = last;
  table_.find(last.address)->position = position;
}

Address Registrations::remove_last(Client& owner) {
  const Address address = owner.mailboxes.back().address;
  owner.mailboxes.pop_back();
  const Table::Entry* entry = table_.find(address);
  withdraw(owner, *entry);
  table_.erase(entry);
  addresses_.erase(address);
  return address;
}

std::optional<Origin> Registrations::waiting_origin(Address address, ClientId link) const {
  const auto [first, last] = waiting_.equal_range(address.raw());
  for (auto entry = first; entry != last; ++entry) {
    if (entry->second.link == link) return entry->second.origin;
  }
  return std::nullopt;
}

bool Registrations::stop_waiting(Address address, ClientId link) {
  const auto [first, last] = waiting_.equal_range(address.raw());
  for (auto entry = first; entry != last; ++entry) {
    if (entry->second.link != link) continue;
    waiting_.erase(entry);
    return true;
  }
  return false;
}

void Registrations::stop_waiting(ClientId link) {
  std::erase_if(waiting_, [&](const auto& entry) { return entry.second.link == link; });
}

std::optional<Registrations::Waiting> Registrations::take_waiting(Address address) {
  const auto [first, last] = waiting_.equal_range(address.raw());
  if (first == last) return std::nullopt;
  const auto best = std::min_element(first, last, [](const auto& a, const auto& b) {
    return a.second.origin.hops < b.second.origin.hops;
  });
  const Waiting taken = best->second;
  waiting_.erase(best);
  return taken;
}

}  // namespace tims::core
