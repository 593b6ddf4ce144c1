#include "client/route.h"

#include "shm/mailbox_view.h"

namespace tims::client {

void PeerSegment::retire() {
  if (++retired_ < offsets_.size()) return;
  mapping_.replace([this](std::span<std::byte> fresh) {
    for (const std::uint64_t offset : offsets_)
      reinterpret_cast<shm::MailboxHeader*>(fresh.data() + offset)
          ->closed.store(1, std::memory_order_relaxed);
  });
}

Route& RouteTable::add(Address address) {
  const std::lock_guard lock(mutex_);
  if (Route* known = find(*table_.load(std::memory_order_relaxed), address)) return *known;
  if (2 * (routes_.size() + 1) > tables_.back()->cells.size())
    grow(2 * tables_.back()->cells.size());
  routes_.push_back(std::make_unique<Route>(address));
  put(*tables_.back(), routes_.back().get());
  return *routes_.back();
}

void RouteTable::forget(Address address) {
  if (Route* known = find(*table_.load(std::memory_order_acquire), address))
    known->target.store(nullptr, std::memory_order_release);
}

void RouteTable::put(Table& table, Route* route) {
  const std::size_t mask = table.cells.size() - 1;
  std::size_t i = std::hash<Address>{}(route->address) >> 32;
  while (table.cells[i & mask].load(std::memory_order_relaxed) != nullptr) ++i;
  table.cells[i & mask].store(route, std::memory_order_release);
}

// Readers may still be in the old table: it stays until the end.
void RouteTable::grow(std::size_t size) {
  tables_.push_back(std::make_unique<Table>(size));
  for (const auto& route : routes_) put(*tables_.back(), route.get());
  table_.store(tables_.back().get(), std::memory_order_release);
}

}  // namespace tims::client
