#include "router/core/registrations.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "router/core/random.h"

namespace tims::core {
namespace {

bool is_link(const Client& owner) { return owner.info.port == PortKind::kLink; }

// Mailboxes above and beside this router are not announced by it.
bool is_below(const Client& owner) {
  return !is_link(owner) || owner.info.link.kind == LinkKind::kSub;
}

}  // namespace

std::uint32_t table_hash(Address address, const Origin& origin) {
  std::uint64_t h =
      (std::uint64_t{address.raw()} << 32 | origin.router.raw()) + 0x9E3779B97F4A7C15U;
  h ^= (std::uint64_t{origin.epoch} << 8 | origin.hops) * 0xC2B2AE3D27D4EB4FU;
  h = spread(h);
  return static_cast<std::uint32_t>(h ^ h >> 32);
}

void MissingRouters::add(MissingRouter missing) {
  const auto is_over = [&](const MissingRouter& other) {
    return missing.since >= other.since + kMissingRouterKept;
  };
  while (!list_.empty() && (list_.size() == kMissingRoutersMax || is_over(list_.front())))
    list_.pop_front();
  missing.number = ++numbers_;
  list_.push_back(missing);
}

void MissingRouters::found(Address router) {
  std::erase_if(list_, [&](const MissingRouter& missing) { return missing.router == router; });
}

bool Registrations::is_exported(const Client& owner, Address address) const {
  return is_below(owner) && address != text_sink_;
}

Origin Registrations::origin(const Client& owner, const Table::Entry& entry) const {
  return is_link(owner) ? origins_.at(entry.handle) : here_;
}

void Registrations::add(Time now, Client& owner, Address address, std::uint32_t handle) {
  assert(!is_link(owner));
  insert(now, owner, address, handle);
  if (is_exported(owner, address)) exported_.added(address, here_);
}

void Registrations::add(Time now, Client& link, Address address, const Origin& origin) {
  assert(is_link(link));
  insert(now, link, address, origins_.hold(origin));
  if (is_exported(link, address)) exported_.added(address, origin);
}

void Registrations::withdraw(const Client& owner, const Table::Entry& entry) {
  if (is_exported(owner, entry.address)) exported_.removed(entry.address, origin(owner, entry));
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
  // The last list entry takes the place of the removed one.
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

// --- clients

Client& Clients::add(const ClientInfo& info, Time now) {
  if ((size_ + 1) * 2 > slots_.size()) grow();
  do {
    ++last_.value;
  } while (!last_ || slot(last_));
  auto& client = slot(last_);
  client = std::make_unique<Client>();
  client->id = last_;
  client->info = info;
  client->connected_at = now;
  ++size_;
  ++sizes_[static_cast<std::size_t>(info.port)];
  return *client;
}

void Clients::remove(ClientId id) {
  const Client* client = find(id);
  if (client == nullptr) return;
  --sizes_[static_cast<std::size_t>(client->info.port)];
  --size_;
  slot(id).reset();
}

// Numbers that differ modulo n also differ modulo 2n, so no collision occurs in the new slots.
void Clients::grow() {
  auto old = std::exchange(slots_, std::vector<std::unique_ptr<Client>>(slots_.size() * 2));
  for (auto& client : old) {
    if (client) slot(client->id) = std::move(client);
  }
}

}  // namespace tims::core
