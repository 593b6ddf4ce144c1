// Messages that local clients cannot deliver themselves.
#include <cstring>

#include "os/event_fd.h"
#include "os/readable.h"
#include "router/io/client_port.h"
#include "shm/reclaim.h"

namespace tims::io {

namespace {

// Of one client, before others have theirs.
constexpr int kMessagesPerTurn = Uplink::kSlots / 2;

}  // namespace

void ClientPort::on_doorbell(LocalClient& client) {
  os::drain_event_fd(client.uplink->doorbell().get());
  begin_turn();
  if (!drain(client, kMessagesPerTurn)) continue_later(client);
  end_turn();
}

// Until the uplink is empty and its doorbell armed: true.
bool ClientPort::drain(LocalClient& client, int messages_max) {
  shm::Receiver& receiver = client.uplink->receiver();
  for (int n = 0; n < messages_max;) {
    const auto taken = receiver.take();
    if (taken) {
      forward(client, *taken);
      client.uplink->release(*taken);
      ++client.taken_before_record;
      ++n;
    } else if (receiver.rest()) {
      return true;
    }
  }
  return false;
}

// What a client sent before it said something, or closed, goes first. Called again and again while
// there is something to read, and true once all that was there when that came has gone: as much as
// an uplink holds.
bool ClientPort::take_what_came_before(LocalClient& client) {
  if (!client.uplink) return true;
  if (!os::is_readable(client.socket.get())) return false;
  if (!drain(client, kMessagesPerTurn) && client.taken_before_record < Uplink::kSlots) return false;
  client.taken_before_record = 0;
  return true;
}

// The connection has ended. What was sent goes on, also what its sender died before announcing; a
// client that lives learns from its next message, or the one it is writing, that it must look for
// another uplink.
void ClientPort::take_the_rest(LocalClient& client) {
  if (!client.uplink) return;
  const shm::MailboxView& view = client.uplink->receiver().view();
  shm::condemn(view);
  shm::reclaim(view, [](std::uint32_t) { return true; });
  (void)drain(client, Uplink::kSlots);
}

void ClientPort::continue_later(LocalClient& client) {
  loop_.post([this, token = client.token, id = client.id] {
    if (!clients_[token] || clients_[token]->id != id) return;
    begin_turn();
    if (!drain(*clients_[token], kMessagesPerTurn)) continue_later(*clients_[token]);
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
