// Messages that local clients cannot deliver themselves.
#include <cstring>

#include "os/event_fd.h"
#include "router/io/client_port.h"

namespace tims::io {

namespace {

// Of one client, before others have theirs; half of what its uplink holds.
constexpr int kMessagesPerTurn = 512;

}  // namespace

void ClientPort::on_doorbell(LocalClient& client) {
  os::drain_event_fd(client.uplink->doorbell().get());
  begin_turn();
  drain(client);
  end_turn();
}

// Until the uplink is empty and its doorbell armed, or others should have their turn.
void ClientPort::drain(LocalClient& client) {
  if (!client.uplink) return;
  shm::Receiver& receiver = client.uplink->receiver();
  for (int n = 0; n < kMessagesPerTurn; ++n) {
    const auto taken = receiver.take();
    if (taken) {
      forward(client, *taken);
      client.uplink->release(*taken);
      continue;
    }
    if (receiver.rest()) return;
  }
  continue_later(client);
}

void ClientPort::continue_later(LocalClient& client) {
  loop_.post([this, token = client.token, id = client.id] {
    if (!clients_[token] || clients_[token]->id != id) return;
    begin_turn();
    drain(*clients_[token]);
    end_turn();
  });
}

// The sender can still write to its slot: what is forwarded is a copy that nobody can change.
void ClientPort::forward(LocalClient& client, const shm::Taken& taken) {
  std::span<std::byte> copy = room(taken.header.length);
  if (!taken.body.empty())
    std::memcpy(copy.data() + kHeaderSize, taken.body.data(), taken.body.size());
  core::Message message{taken.header, copy};
  delivered_here_ = false;
  router_.on_message(now_, client.id, message);
  if (!delivered_here_) return;
  // It could have come by itself: the receiver is on this host by now.
  if (find_local(taken.header.dest) != nullptr)
    (void)send(client, 0, wire::Moved{taken.header.dest});
}

// Memory that stays as it is until the ports are flushed.
std::span<std::byte> ClientPort::room(std::size_t size) {
  if (copied_ + size > copies_.size()) {
    end_turn();
    if (size > copies_.size()) copies_.resize(size);
  }
  const std::span room = std::span(copies_).subspan(copied_, size);
  copied_ += size;
  return room;
}

}  // namespace tims::io
