#include "router/io/local_port.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "router/io/subjects.h"
#include "shm/layout.h"
#include "wire/header.h"

namespace tims::io {
namespace {

using namespace std::chrono_literals;
constexpr std::size_t kCopiesBytes = 256 << 10;
constexpr int kRecordsPerTurn = 64;  // limit for one client, before others have their turn
// After the start, clients of a previous router have this time to reconnect before half-written
// slots of unknown writers are reclaimed.
constexpr Duration kReturnGrace = 10s;

// Segments that were offered without a mailbox opened in them: a correct client opens one before
// it offers the next.
constexpr std::size_t kUnusedSegmentsMax = 16;
constexpr const char* kNoDescriptor =
    "is not registered: the router has no file descriptor left for this program, whose limit is a "
    "quarter of them: open mailboxes together, or raise the router's limit (LimitNOFILE, ulimit "
    "-n)";

// The share of the router's descriptors for the memory and the eventfds of one client.
std::size_t descriptors_for_one() {
  rlimit limit{};
  return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur / 4 : 0;
}

// Limit for one client, before others have their turn.
constexpr int kUplinkSlots = 1024;  // messages
constexpr std::uint32_t kUplinkLongPlaces = 64;
constexpr int kMessagesPerTurn = kUplinkSlots / 2;
constexpr std::size_t kToldMax = 4096;  // addresses that one client has to look up again

// Description of a client: "pid 4711 (laser)", "127.0.0.1:40312".
std::string describe(const core::Peer& peer) {
  if (!peer.id) return "the router itself";
  std::string text;
  if (peer.pid != 0) text.append("pid ").append(std::to_string(peer.pid));
  if (!peer.endpoint.empty()) text.append(text.empty() ? "" : " ").append(peer.endpoint.view());
  if (!peer.name.empty()) text.append(" (").append(peer.name.view()).append(")");
  return text;
}

}  // namespace

LocalPort::LocalPort(Loop& loop, core::Router& router, Log& log, LocalPortSettings settings)
    : loop_(loop),
      router_(router),
      settings_(std::move(settings)),
      acceptor_(loop, log, [this](os::File socket, const Visitor&) { accept(std::move(socket)); }),
      sweep_(loop, [this] { sweep_orphans(); }),
      // Each start uses another range, so that clients of the previous router keep their numbers.
      last_writer_(static_cast<std::uint32_t>(settings_.epoch) & shm::SlotWord::kMask24),
      record_(wire::kRecordBytesMax),
      copies_(kCopiesBytes) {}

LocalPort::~LocalPort() { remove_socket_file(); }

Result<void> LocalPort::listen(os::SocketStore& store) {
  const mode_t mode = settings_.everybody ? 0666 : 0660;
  os::File listener = store.take_unix(settings_.path);
  if (listener) {
    ::chmod(settings_.path.c_str(), mode);
  } else {
    auto opened = os::listen_unix(settings_.path, mode);
    if (!opened) return opened.error();
    listener = std::move(*opened);
  }
  // The file of a socket that is kept stays: clients that connect meanwhile wait there.
  if (!store.keep(listener.get())) socket_file_ = os::file_at(settings_.path);
  acceptor_.listen(std::move(listener));
  sweep_.set(os::now() + kReturnGrace);
  return {};
}

// Called before the socket is closed: until then no other file can have the same identity.
void LocalPort::stop_accepting() {
  remove_socket_file();
  acceptor_.stop();
}

// Not the file of another router that was started on the same path in between.
void LocalPort::remove_socket_file() {
  if (socket_file_.inode != 0 && os::file_at(settings_.path) == socket_file_)
    ::unlink(settings_.path.c_str());
  socket_file_ = {};
}

void LocalPort::accept(os::File socket) {
  const std::uint32_t token = clients_.next();
  LocalClient& client = clients_.add(std::make_unique<LocalClient>());
  client.token = token;
  client.socket = std::move(socket);
  client.peer = os::local_peer(client.socket.get()).value_or(os::LocalPeer());
  client.socket_watch.emplace(loop_, client.socket.get(),
                              [this, &client](Ready) { on_records(client); });
}

void LocalPort::on_records(LocalClient& client) {
  const Time now = os::now();
  receive_some(now, client);
  end_turn(now);
}

void LocalPort::end_turn(Time now) {
  loop_.end_turn(now);
  copied_ = 0;
}

// The client may be destroyed afterwards.
void LocalPort::receive_some(Time now, LocalClient& client) {
  const std::uint32_t token = client.token;
  for (int n = 0; n < kRecordsPerTurn; ++n) {
    if (!drain_earlier_messages(now, client)) return;
    auto received = os::receive_record(client.socket.get(), record_, false);
    if (!received && received.error() == Errc::kEmpty) return;
    if (!received || received->size == 0) return drop(now, token, core::CloseReason::kPeerClosed);
    auto decoded = wire::decode(std::span(record_).first(received->size));
    if (received->truncated || !decoded.packet || !handle(now, client, *decoded.packet, *received))
      return drop(now, token, core::CloseReason::kBadRecord);
    if (clients_.find(token) != &client) return;
  }
}

// A connection that has hung up, but has not been processed yet, must not block a new one.
void LocalPort::drop_if_hung_up(Time now, std::uint32_t token) {
  if (os::has_hung_up(clients_.find(token)->socket.get()))
    drop(now, token, core::CloseReason::kPeerClosed);
}

void LocalPort::drop(Time now, std::uint32_t token, core::CloseReason reason) {
  LocalClient& client = *clients_.find(token);
  drain_remaining_messages(now, client);
  router_.disconnect(now, client.id, reason);
  forget(client);
}

// Releases everything the client had, and its half-written slots in mailboxes of others.
void LocalPort::forget(LocalClient& client) {
  for (const auto& [address, handle] : client.mailboxes) memory_.remove_mailbox(handle);
  for (const auto& [number, segment] : client.offered) memory_.drop_if_empty(segment);
  for (const os::ClientMemory::SegmentId segment : client.known)
    memory_.reclaim(segment, [&](std::uint32_t writer) { return writer == client.writer; });
  writers_.erase(client.writer);
  clients_.erase(client.token);
}

// --- Port

core::Outcome LocalPort::deliver(Time /*now*/, const core::Receiver& to,
                                 const core::Message& message) {
  const auto outcome = memory_.deliver(to.handle, message.bytes.first<kHeaderSize>(),
                                       message.body(), message.header.priority);
  switch (outcome) {
    case shm::SendOutcome::kOk:
    case shm::SendOutcome::kReplaced:
      break;
    case shm::SendOutcome::kFull:
      return core::Outcome::kMailboxFull;
    case shm::SendOutcome::kTooBig:
      return core::Outcome::kTooBig;
    default:
      return core::Outcome::kOwnerGone;
  }
  delivered_here_ = true;
  return outcome == shm::SendOutcome::kReplaced ? core::Outcome::kMailboxReplaced
                                                : core::Outcome::kDelivered;
}

void LocalPort::reply(Time now, const core::Receiver& to, const Header& header) {
  // A local client receives the router's messages only in its mailboxes.
  if (to.handle == 0) return;
  std::array<std::byte, kHeaderSize> bytes;
  wire::encode_header(header, bytes);
  (void)deliver(now, to, {header, bytes});
}

void LocalPort::close(const core::Receiver& client, core::CloseReason) {
  if (LocalClient* gone = clients_.find(client.token)) forget(*gone);
}

void LocalPort::moved(Address address) {
  clients_.for_each([&](LocalClient& client) {
    if (client.id) (void)send(client, 0, wire::Moved{address});
  });
}

std::optional<MailboxFill> LocalPort::fill(std::uint32_t handle) const {
  const os::ClientMemory::Mailbox* mailbox = memory_.find(handle);
  if (mailbox == nullptr) return std::nullopt;
  const shm::MailboxView& view = mailbox->sender->view();
  return MailboxFill{.slots = view.geometry().slots,
                     .message_max = view.geometry().message_max,
                     .waiting = shm::waiting(view),
                     .counts = shm::counters(view),
                     .asleep = mailbox->sender->sleeper() != 0};
}

void LocalPort::sweep_orphans() {
  memory_.reclaim_everywhere([this](std::uint32_t writer) {
    return writer != kRouterWriter && !writers_.contains(writer);
  });
}

// --- requests of clients

bool LocalPort::handle(Time now, LocalClient& client, wire::Packet& packet,
                       os::Received& received) {
  const std::uint32_t request = packet.request;
  const wire::Record& record = packet.record;
  if (const auto* r = std::get_if<wire::Hello>(&record)) return hello(now, client, request, *r);
  if (!client.id) return false;  // hello must be first
  if (const auto* r = std::get_if<wire::OfferSegment>(&record)) return offer(client, *r, received);
  if (const auto* r = std::get_if<wire::Open>(&record))
    return open(now, client, request, *r, received);
  if (const auto* r = std::get_if<wire::Close>(&record))
    return close_mailboxes(now, client, request, *r);
  if (const auto* r = std::get_if<wire::Lookup>(&record)) return look_up(client, request, *r);
  if (std::holds_alternative<wire::UplinkRequest>(record)) return grant_uplink(client, request);
  return false;  // a record that only the router may send
}

bool LocalPort::hello(Time now, LocalClient& client, std::uint32_t request,
                      const wire::Hello& hello) {
  if (client.id) return false;
  if (hello.version_min > wire::kLocalVersion || hello.version_max < wire::kLocalVersion) {
    const std::string text = "this router supports version " + std::to_string(wire::kLocalVersion) +
                             " of the local protocol, the client supports " +
                             std::to_string(hello.version_min) + " to " +
                             std::to_string(hello.version_max) + ": update the older one";
    (void)send(client, request, wire::Refused{text});
    return false;
  }
  // The client lost its connection and reconnected before the end of the old one was processed.
  if (const auto former = writers_.find(hello.writer); former != writers_.end())
    drop_if_hung_up(now, former->second);
  client.id = router_.connect(now, {.port = core::PortKind::kLocal,
                                    .token = client.token,
                                    .pid = static_cast<std::uint32_t>(client.peer.pid),
                                    .uid = client.peer.uid,
                                    .name = std::string_view(hello.name),
                                    .subject = local_subject(client.peer)});
  if (!client.id) {
    (void)send(client, request,
               wire::Refused{"as many clients as limits.clients allows: increase it"});
    return false;
  }
  client.writer = writer_for(hello.writer);
  writers_[client.writer] = client.token;
  return send(client, request,
              wire::Welcome{.version = wire::kLocalVersion,
                            .writer = client.writer,
                            .router = settings_.router,
                            .epoch = settings_.epoch,
                            .message_max = settings_.message_max,
                            .widths = router_.settings().widths});
}

// The number the client had with the previous router, if it is free: slots that are being written
// now remain its own.
std::uint32_t LocalPort::writer_for(std::uint32_t requested) {
  const auto free = [this](std::uint32_t w) {
    return w != 0 && w < kRouterWriter && !writers_.contains(w);
  };
  if (free(requested)) return requested;
  do last_writer_ = (last_writer_ + 1) & shm::SlotWord::kMask24;
  while (!free(last_writer_));
  return last_writer_;
}

// A client that waited for a long time may send this twice: the first offer is valid.
bool LocalPort::offer(LocalClient& client, const wire::OfferSegment& offer,
                      os::Received& received) {
  if (client.offered.contains(offer.segment)) return true;
  if (client.offered.size() >= client.mailboxes.size() + kUnusedSegmentsMax) return false;
  const bool has_room = client.offered.size() + client.wakers < descriptors_for_one();
  if (received.files.size() == 1 && has_room) {
    client.offered[offer.segment] = memory_.offer(std::move(received.files.front()));
    return true;
  }
  client.offered[offer.segment] = os::ClientMemory::kLost;
  return received.files_lost || !has_room;
}

// Opens all of them or none.
bool LocalPort::open(Time now, LocalClient& client, std::uint32_t request, const wire::Open& open,
                     os::Received& received) {
  wire::Opened opened;
  for (const wire::OpenEntry& entry : open.entries)
    opened.entries.push_back({entry.address, wire::OpenStatus::kNotTried});
  auto file = received.files.begin();
  bool ok = true;
  std::size_t done = 0;
  for (; ok && done < open.entries.size(); ++done) {
    const wire::OpenEntry& entry = open.entries[done];
    wire::OpenStatus& status = opened.entries[done].status;
    const bool missing = entry.has_waker && file == received.files.end();
    if (missing && !received.files_lost) return false;
    const bool too_many =
        entry.has_waker && client.offered.size() + client.wakers >= descriptors_for_one();
    if (missing || too_many) {
      opened.text = kNoDescriptor;
      status = wire::OpenStatus::kTooMany;
    } else {
      os::File waker = entry.has_waker ? std::move(*file++) : os::File();
      status = open_one(now, client, entry, std::move(waker), opened.text);
    }
    ok = status == wire::OpenStatus::kOk;
  }
  if (!ok) {
    for (std::size_t i = 0; i + 1 < done; ++i) {
      close_mailbox(now, client, open.entries[i].address);
      opened.entries[i].status = wire::OpenStatus::kNotTried;
    }
    drop_unused(client);
  }
  return send(client, request, opened);
}

wire::OpenStatus LocalPort::open_one(Time now, LocalClient& client, const wire::OpenEntry& entry,
                                     os::File waker, std::string& text) {
  if (has_opened(client, entry)) return wire::OpenStatus::kOk;
  const auto offered = client.offered.find(entry.place.segment);
  if (offered == client.offered.end()) {
    text = "is not registered: no such segment was offered";
    return wire::OpenStatus::kBadPlace;
  }
  if (offered->second == os::ClientMemory::kLost) {
    text = kNoDescriptor;
    return wire::OpenStatus::kTooMany;
  }
  auto handle =
      memory_.add_mailbox(offered->second, entry.place.offset, entry.address, std::move(waker));
  if (!handle) {
    text = "is not registered: " + handle.error().message();
    return wire::OpenStatus::kBadPlace;
  }
  const wire::OpenStatus status = register_one(now, client, entry.address, *handle, text);
  if (status == wire::OpenStatus::kOk) {
    client.mailboxes[entry.address.raw()] = *handle;
    client.wakers += entry.has_waker ? 1 : 0;
    memory_.open_mailbox(*handle);
  } else {
    memory_.withdraw_mailbox(*handle);
  }
  return status;
}

bool LocalPort::has_opened(const LocalClient& client, const wire::OpenEntry& entry) const {
  const auto own = client.mailboxes.find(entry.address.raw());
  const auto offered = client.offered.find(entry.place.segment);
  if (own == client.mailboxes.end() || offered == client.offered.end()) return false;
  const os::ClientMemory::Mailbox* mailbox = memory_.find(own->second);
  return mailbox->segment == offered->second && mailbox->offset == entry.place.offset;
}

wire::OpenStatus LocalPort::register_one(Time now, LocalClient& client, Address address,
                                         os::ClientMemory::Handle handle, std::string& text) {
  if (const auto* entry = router_.find(address)) {
    const core::Client* owner = router_.client(entry->owner);
    if (owner != nullptr && owner->info.port == core::PortKind::kLocal && owner->id != client.id)
      drop_if_hung_up(now, owner->info.token);
  }
  using Status = core::Registration::Status;
  const core::Registration result = router_.register_mailbox(now, client.id, address, handle);
  if (result.status == Status::kOk) return wire::OpenStatus::kOk;
  if (result.status == Status::kAddressInUse) {
    const core::Client* owner = router_.client(result.owner);
    text = "belongs to " + describe(owner == nullptr ? core::Peer{} : owner->peer());
    return wire::OpenStatus::kAddressInUse;
  }
  text = "is not registered: more mailboxes than limits.mailboxes_per_client allows: increase it";
  return wire::OpenStatus::kTooMany;
}

bool LocalPort::close_mailboxes(Time now, LocalClient& client, std::uint32_t request,
                                const wire::Close& close) {
  for (const Address address : close.addresses) close_mailbox(now, client, address);
  if (!close.addresses.empty()) drop_unused(client);
  return send(client, request, wire::Closed{});
}

// Releases memory that contains no mailbox of the client.
void LocalPort::drop_unused(LocalClient& client) {
  std::erase_if(client.offered, [this](const auto& entry) {
    memory_.drop_if_empty(entry.second);
    return !memory_.knows(entry.second);
  });
}

void LocalPort::close_mailbox(Time now, LocalClient& client, Address address) {
  const auto own = client.mailboxes.find(address.raw());
  if (own == client.mailboxes.end()) return;
  router_.remove_mailbox(now, client.id, address);
  client.wakers -= memory_.mailbox(own->second).waker ? 1 : 0;
  memory_.remove_mailbox(own->second);
  client.mailboxes.erase(own);
}

bool LocalPort::look_up(LocalClient& client, std::uint32_t request, const wire::Lookup& lookup) {
  return std::ranges::all_of(lookup.addresses,
                             [&](Address address) { return found(client, request, address); });
}

const core::Table::Entry* LocalPort::find_local(Address address) const {
  if (address == router_.text_sink() && router_.shares_texts()) return nullptr;
  const auto* entry = router_.find(address);
  return entry != nullptr && router_.is_direct(*entry) ? entry : nullptr;
}

bool LocalPort::found(LocalClient& client, std::uint32_t request, Address address) {
  client.told_moved.erase(address.raw());
  // Messages of a program under the policy go through the router.
  const bool is_judged = router_.client(client.id)->is_judged();
  const auto* entry = is_judged ? nullptr : find_local(address);
  if (entry == nullptr) return send(client, request, wire::Found{address, false, {}, false});
  const os::ClientMemory::Mailbox& mailbox = memory_.mailbox(entry->handle);
  std::vector<int> files{memory_.memfd(mailbox.segment).get()};
  if (mailbox.waker) files.push_back(mailbox.waker.get());
  client.known.insert(mailbox.segment);
  return send(client, request,
              wire::Found{.address = address,
                          .local = true,
                          .place = {mailbox.segment, mailbox.offset},
                          .has_waker = static_cast<bool>(mailbox.waker)},
              files);
}

bool LocalPort::grant_uplink(LocalClient& client, std::uint32_t request) {
  if (!client.uplink) {
    auto uplink = os::Uplink::make("tims-uplink", {.slots = kUplinkSlots,
                                                   .long_places = kUplinkLongPlaces,
                                                   .message_max = settings_.message_max});
    if (!uplink) return send(client, request, wire::Refused{uplink.error().message()});
    client.uplink = std::move(*uplink);
    client.doorbell_watch.emplace(loop_, client.uplink->doorbell().get(),
                                  [this, &client](Ready) { on_doorbell(client); });
  }
  const std::array files{client.uplink->memfd().get(), client.uplink->doorbell().get()};
  return send(client, request, wire::Uplink{}, files);
}

// A client whose socket accepts no more answers does not read them, and cannot continue without
// them. A client that has just disconnected did not violate the protocol.
bool LocalPort::send(LocalClient& client, std::uint32_t request, const wire::Record& record,
                     std::span<const int> files) {
  std::vector<std::byte> bytes;
  wire::encode({request, record}, bytes);
  const auto sent = os::send_record(client.socket.get(), bytes, files, false);
  return sent.ok() || sent.error() == Errc::kClosed;
}

// --- messages that clients cannot deliver directly

void LocalPort::on_doorbell(LocalClient& client) {
  // Each ring is an event, whatever the counter of the doorbell is.
  client.doorbell_watch->all_taken();
  const Time now = os::now();
  if (!drain(now, client, kMessagesPerTurn)) continue_later(client);
  end_turn(now);
}

// Drains the uplink until it is empty and its doorbell is armed; then returns true.
bool LocalPort::drain(Time now, LocalClient& client, int messages_max) {
  shm::Receiver& receiver = client.uplink->receiver();
  for (int n = 0; n < messages_max;) {
    const auto taken = receiver.take();
    if (taken) {
      forward(now, client, *taken);
      client.uplink->release(*taken);
      ++client.taken_before_record;
      ++n;
    } else if (receiver.rest()) {
      return true;
    }
  }
  return false;
}

// Messages sent before a record, or before the end of the connection, are processed first. Called
// repeatedly while there is something to read; returns true once all messages that existed when
// the record arrived have been forwarded: at most the capacity of an uplink.
bool LocalPort::drain_earlier_messages(Time now, LocalClient& client) {
  if (!client.uplink) return true;
  if (!os::is_readable(client.socket.get())) return false;
  if (!drain(now, client, kMessagesPerTurn) && client.taken_before_record < kUplinkSlots)
    return false;
  client.taken_before_record = 0;
  return true;
}

// The connection has ended. Its remaining messages are forwarded, including those the sender
// could not announce before it crashed. A client that is still running learns with its next
// message, or the one it is writing, that it needs another uplink.
void LocalPort::drain_remaining_messages(Time now, LocalClient& client) {
  if (!client.uplink) return;
  const shm::MailboxView& view = client.uplink->receiver().view();
  shm::condemn(view);
  shm::reclaim(view, [](std::uint32_t) { return true; });
  (void)drain(now, client, kUplinkSlots);
}

void LocalPort::continue_later(LocalClient& client) {
  loop_.post([this, token = client.token, id = client.id] {
    LocalClient* still = clients_.find(token);
    if (still == nullptr || still->id != id) return;
    const Time now = os::now();
    if (!drain(now, *still, kMessagesPerTurn)) continue_later(*still);
    end_turn(now);
  });
}

// The sender can still write to its slot, so a private copy is forwarded.
void LocalPort::forward(Time now, LocalClient& client, const shm::Taken& taken) {
  std::span<std::byte> copy = room(now, taken.header.length);
  if (!taken.body.empty())
    std::memcpy(copy.data() + kHeaderSize, taken.body.data(), taken.body.size());
  core::Message message{taken.header, copy};
  delivered_here_ = false;
  router_.on_message(now, client.id, message);
  const core::Client* sender = router_.client(client.id);
  if (!delivered_here_ || sender == nullptr || sender->is_judged()) return;
  // The receiver is on this host now, so the client could have delivered the message directly.
  if (find_local(taken.header.dest) != nullptr) tell_moved(client, taken.header.dest);
}

// Once until it looks the address up again: a fast sender does not read as fast as it writes, and
// is disconnected when its socket is full.
void LocalPort::tell_moved(LocalClient& client, Address address) {
  if (client.told_moved.size() >= kToldMax) client.told_moved.clear();
  if (client.told_moved.insert(address.raw()).second) (void)send(client, 0, wire::Moved{address});
}

// Memory that stays valid until the ports are flushed.
std::span<std::byte> LocalPort::room(Time now, std::size_t size) {
  if (copied_ + size > copies_.size()) {
    end_turn(now);
    if (size > copies_.size()) copies_.resize(size);
  }
  const std::span room = std::span(copies_).subspan(copied_, size);
  copied_ += size;
  return room;
}

}  // namespace tims::io
