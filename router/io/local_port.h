// The port for programs of this host: a Unix socket for control records and file descriptors,
// shared memory for messages. Records: libtims/wire/local_protocol.h.
//
// Messages between two local programs bypass this port. It handles messages to receivers on other
// hosts or attached by TCP (through each client's uplink), and messages from those to local
// mailboxes, which the router writes into the receiver's slots like any other sender.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/slot_map.h"
#include "os/client_memory.h"
#include "os/peer.h"
#include "os/socket.h"
#include "router/core/router.h"
#include "router/core/types.h"
#include "router/io/acceptor.h"
#include "router/io/admin_source.h"
#include "router/io/loop.h"
#include "tims/result.h"
#include "wire/local_protocol.h"

namespace tims::io {

// The router's own identity as a writer: its slots are never reclaimed while it is running.
inline constexpr std::uint32_t kRouterWriter = 0xFFFFFF;

// One program of this host.
struct LocalClient {
  os::File socket;
  os::LocalPeer peer;
  std::optional<Watch> socket_watch;
  core::ClientId id;  // kNoClient until its hello has been received
  std::uint32_t token = 0;
  std::uint32_t writer = 0;
  // Keyed by the client's own segment numbers.
  std::unordered_map<std::uint64_t, os::ClientMemory::SegmentId> offered;
  std::unordered_map<std::uint32_t, os::ClientMemory::Handle> mailboxes;  // by raw address
  // Eventfds of its mailboxes.
  std::size_t wakers = 0;
  std::unordered_set<os::ClientMemory::SegmentId> known;  // segments it can write to
  std::unique_ptr<os::Uplink> uplink;
  std::optional<Watch> doorbell_watch;
  // Addresses that it has been told to look up again and has not; at most kToldMax.
  std::unordered_set<std::uint32_t> told_moved;
  int taken_before_record = 0;  // messages taken since the next record, or the end, arrived
};

struct LocalPortSettings {
  std::string path;
  bool everybody = false;  // any user of this host may connect; otherwise owner and group
  Address router;
  std::uint64_t epoch = 0;
  std::uint32_t message_max = kMessageMaxDefault;
};

class LocalPort final : public core::Port {
 public:
  LocalPort(Loop& loop, core::Router& router, Log& log, LocalPortSettings settings);
  ~LocalPort() override;

  // `store`: what may have the socket already, and keeps it.
  Result<void> listen(os::SocketStore& store);

  // core::Port
  core::Outcome deliver(Time now, const core::Receiver& to, const core::Message& message) override;
  void reply(Time now, const core::Receiver& to, const Header& header) override;
  void close(const core::Receiver& client, core::CloseReason reason) override;
  void moved(Address address) override;
  void stop_accepting() override;

  // State of a mailbox, by its handle.
  [[nodiscard]] std::optional<MailboxFill> fill(std::uint32_t handle) const;
  [[nodiscard]] shm::Counters mailbox_counts() const { return memory_.counters(); }

 private:
  void accept(os::File socket);
  void remove_socket_file();
  void on_records(LocalClient& client);
  void receive_some(Time now, LocalClient& client);
  void drop_if_hung_up(Time now, std::uint32_t token);
  void drop(Time now, std::uint32_t token, core::CloseReason reason);
  void forget(LocalClient& client);

  // --- requests of clients; false: the client violated the protocol
  bool handle(Time now, LocalClient& client, wire::Packet& packet, os::Received& received);
  bool hello(Time now, LocalClient& client, std::uint32_t request, const wire::Hello& hello);
  bool offer(LocalClient& client, const wire::OfferSegment& offer, os::Received& received);
  bool open(Time now, LocalClient& client, std::uint32_t request, const wire::Open& open,
            os::Received& received);
  wire::OpenStatus open_one(Time now, LocalClient& client, const wire::OpenEntry& entry,
                            os::File waker, std::string& text);
  wire::OpenStatus register_one(Time now, LocalClient& client, Address address,
                                os::ClientMemory::Handle handle, std::string& text);
  [[nodiscard]] bool has_opened(const LocalClient& client, const wire::OpenEntry& entry) const;
  void drop_unused(LocalClient& client);
  void close_mailbox(Time now, LocalClient& client, Address address);
  bool close_mailboxes(Time now, LocalClient& client, std::uint32_t request,
                       const wire::Close& close);
  bool look_up(LocalClient& client, std::uint32_t request, const wire::Lookup& lookup);
  // The owner of a mailbox that local clients may write to directly.
  [[nodiscard]] const core::Table::Entry* find_local(Address address) const;
  bool found(LocalClient& client, std::uint32_t request, Address address);
  bool grant_uplink(LocalClient& client, std::uint32_t request);
  bool send(LocalClient& client, std::uint32_t request, const wire::Record& record,
            std::span<const int> files = {});
  std::uint32_t writer_for(std::uint32_t requested);

  // --- messages that clients cannot deliver directly
  void on_doorbell(LocalClient& client);
  bool drain(Time now, LocalClient& client, int messages_max);
  bool drain_earlier_messages(Time now, LocalClient& client);
  void drain_remaining_messages(Time now, LocalClient& client);
  void forward(Time now, LocalClient& client, const shm::Taken& taken);
  void tell_moved(LocalClient& client, Address address);
  void continue_later(LocalClient& client);
  std::span<std::byte> room(Time now, std::size_t size);
  void end_turn(Time now);

  void sweep_orphans();

  Loop& loop_;
  core::Router& router_;
  const LocalPortSettings settings_;
  Acceptor acceptor_;
  os::FileId socket_file_;  // the file created by this router
  Timer sweep_;
  base::SlotMap<LocalClient> clients_;                        // by token
  std::unordered_map<std::uint32_t, std::uint32_t> writers_;  // connected writers: writer -> token
  std::uint32_t last_writer_;
  os::ClientMemory memory_{kRouterWriter};
  std::vector<std::byte> record_;
  // Messages received through uplinks in this turn, copied out of shared memory.
  std::vector<std::byte> copies_;
  std::size_t copied_ = 0;
  bool delivered_here_ = false;  // the current message was delivered to a local mailbox
};

}  // namespace tims::io
