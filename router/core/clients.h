// The clients that are connected now.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "router/core/ids.h"
#include "router/core/statistics.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

// What a port says about a new client.
struct ClientInfo {
  PortKind port = PortKind::kTcp;
  std::uint32_t token = 0;  // the port's own number for it, handed back with every delivery
  std::uint32_t pid = 0;    // 0: not known
  std::uint32_t uid = 0;
  Text<31> name{};
  Text<55> endpoint{};  // "127.0.0.1:54321"
  struct Link {         // of another router
    LinkKind kind = LinkKind::kSub;
    Role role = Role::kSubsystem;
    std::uint8_t system = 0;
    Address router{};
    std::optional<std::uint8_t> only{};  // nothing but this system comes from it; nothing: any
  } link{};
  bool lifesign = false;  // is asked whether it lives from the start, as original clients are
};

struct OwnedMailbox {
  Address address{};
  std::uint32_t registered_s = 0;  // on the monotonic clock
};

struct Client {
  ClientId id{};
  ClientInfo info{};
  Time connected_at{};
  std::vector<OwnedMailbox> mailboxes{};  // in no order
  bool watched = false;                   // gets lifesigns
  bool owes_answer = false;               // to the last one
  Count in{};                             // from it
  Count out{};                            // to it: taken by its mailbox, connection or queue
  Count dropped{};                        // to it, and lost

  [[nodiscard]] Peer peer() const {
    return {
        .id = id, .port = info.port, .pid = info.pid, .name = info.name, .endpoint = info.endpoint};
  }
};

// A client's slot is its number modulo the number of slots; numbers whose slot is taken are left
// out. So a number leads to its client with one look, and an old number to nobody.
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

  // `visit` may remove the client it is given.
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

  std::vector<std::unique_ptr<Client>> slots_;  // at most half of them taken
  std::size_t size_ = 0;
  std::array<std::size_t, kPortKindCount> sizes_{};
  ClientId last_{};
};

}  // namespace tims::core
