#include "router/core/clients.h"

#include <utility>

namespace tims::core {

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

// Numbers that differ modulo n also differ modulo 2n: nobody meets in the new slots.
void Clients::grow() {
  auto old = std::exchange(slots_, std::vector<std::unique_ptr<Client>>(slots_.size() * 2));
  for (auto& client : old) {
    if (client) slot(client->id) = std::move(client);
  }
}

}  // namespace tims::core
