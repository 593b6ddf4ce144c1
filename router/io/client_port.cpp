#include "router/io/client_port.h"

#include <array>
#include <cstring>

#include <unistd.h>

#include "os/clock.h"
#include "wire/header.h"

namespace tims::io {

namespace {

using namespace std::chrono_literals;
constexpr std::size_t kCopiesBytes = 256 << 10;
constexpr int kRecordsPerTurn = 64;  // of one client, before others have theirs
// After the start: time for the clients of a former router to come back, before slots that
// writers unknown here left half-written are taken back.
constexpr Duration kReturnGrace = 10s;

}  // namespace

ClientPort::ClientPort(Loop& loop, core::Router& router, Log& log,
                       std::function<void(Time)> end_turn, ClientPortSettings settings)
    : loop_(loop),
      router_(router),
      end_turn_(std::move(end_turn)),
      settings_(std::move(settings)),
      acceptor_(loop, log,
                [this](os::File socket, const std::string&) { accept(std::move(socket)); }),
      sweep_(loop, [this] { sweep_orphans(); }),
      // Another start, another range: a client of the former router keeps its number.
      last_writer_(static_cast<std::uint32_t>(settings_.epoch) & shm::SlotWord::kMask24),
      record_(wire::kRecordBytesMax),
      copies_(kCopiesBytes) {}

ClientPort::~ClientPort() { remove_socket_file(); }

Result<void> ClientPort::listen() {
  auto listener = os::listen_unix(settings_.path, settings_.everybody ? 0666 : 0660);
  if (!listener) return listener.error();
  socket_file_ = os::file_at(settings_.path);
  acceptor_.listen(std::move(*listener));
  sweep_.set(os::now() + kReturnGrace);
  return {};
}

// Before the socket is closed: until then no other file can be taken for ours.
void ClientPort::stop_accepting() {
  remove_socket_file();
  acceptor_.stop();
}

// Not that of another router, which was started on the same path meanwhile.
void ClientPort::remove_socket_file() {
  if (socket_file_.inode != 0 && os::file_at(settings_.path) == socket_file_)
    ::unlink(settings_.path.c_str());
  socket_file_ = {};
}

void ClientPort::accept(os::File socket) {
  std::uint32_t token = static_cast<std::uint32_t>(clients_.size());
  if (free_tokens_.empty()) {
    clients_.emplace_back();
  } else {
    token = free_tokens_.back();
    free_tokens_.pop_back();
  }
  clients_[token] = std::make_unique<LocalClient>();
  LocalClient& client = *clients_[token];
  client.token = token;
  client.socket = std::move(socket);
  client.socket_watch.emplace(loop_, client.socket.get(),
                              [this, &client](Ready) { on_records(client); });
}

void ClientPort::on_records(LocalClient& client) {
  begin_turn();
  receive_some(client);
  end_turn();
}

void ClientPort::begin_turn() { now_ = os::now(); }

void ClientPort::end_turn() {
  end_turn_(now_);
  copied_ = 0;
}

// The client may be gone afterwards.
void ClientPort::receive_some(LocalClient& client) {
  const std::uint32_t token = client.token;
  for (int n = 0; n < kRecordsPerTurn; ++n) {
    if (!take_what_came_before(client)) return;
    auto received = os::receive_record(client.socket.get(), record_, false);
    if (!received && received.error() == Errc::kEmpty) return;
    if (!received || received->size == 0) return drop(token, core::CloseReason::kPeerClosed);
    auto decoded = wire::decode(std::span(record_).first(received->size));
    if (received->truncated || !decoded.packet || !handle(client, *decoded.packet, *received))
      return drop(token, core::CloseReason::kBadRecord);
    if (clients_[token].get() != &client) return;
  }
}

// A connection whose end nobody has looked at yet is in nobody's way.
void ClientPort::drop_if_hung_up(std::uint32_t token) {
  if (os::has_hung_up(clients_[token]->socket.get())) drop(token, core::CloseReason::kPeerClosed);
}

void ClientPort::drop(std::uint32_t token, core::CloseReason reason) {
  LocalClient& client = *clients_[token];
  take_the_rest(client);
  router_.disconnect(now_, client.id, reason);
  forget(client);
}

// Everything the client had and may have left behind in others' mailboxes.
void ClientPort::forget(LocalClient& client) {
  for (const auto& [address, handle] : client.mailboxes) segments_.remove_mailbox(handle);
  for (const auto& [number, segment] : client.offered) segments_.drop_if_empty(segment);
  for (const LocalSegments::SegmentId segment : client.known)
    segments_.reclaim(segment, [&](std::uint32_t writer) { return writer == client.writer; });
  writers_.erase(client.writer);
  free_tokens_.push_back(client.token);
  clients_[client.token].reset();
}

// --- Port

core::Outcome ClientPort::deliver(const core::Receiver& to, const core::Message& message) {
  LocalSegments::Mailbox& mailbox = segments_.mailbox(to.handle);
  if (!mailbox.sender) return core::Outcome::kOwnerGone;
  shm::Claim claim;
  const auto outcome = mailbox.sender->claim(static_cast<std::uint32_t>(message.bytes.size()),
                                             message.header.priority, claim);
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
  std::memcpy(claim.header, message.bytes.data(), kHeaderSize);
  if (!message.body().empty())
    std::memcpy(claim.body, message.body().data(), message.body().size());
  if (mailbox.sender->commit(claim) != shm::SendOutcome::kOk) return core::Outcome::kOwnerGone;
  LocalSegments::wake(mailbox);
  delivered_here_ = true;
  return outcome == shm::SendOutcome::kReplaced ? core::Outcome::kMailboxReplaced
                                                : core::Outcome::kDelivered;
}

void ClientPort::reply(const core::Receiver& to, const Header& header) {
  if (to.handle == 0) return;  // a local client hears of the router only in its mailboxes
  std::array<std::byte, kHeaderSize> bytes;
  wire::encode_header(header, bytes);
  (void)deliver(to, {header, bytes});
}

void ClientPort::close(const core::Receiver& client, core::CloseReason) {
  if (clients_[client.token]) forget(*clients_[client.token]);
}

void ClientPort::moved(Address address) {
  for (const auto& client : clients_)
    if (client && client->id) (void)send(*client, 0, wire::Moved{address});
}

std::optional<MailboxFill> ClientPort::fill(std::uint32_t handle) const {
  const LocalSegments::Mailbox* mailbox = segments_.find(handle);
  if (mailbox == nullptr) return std::nullopt;
  const shm::MailboxView& view = mailbox->sender->view();
  return MailboxFill{.slots = view.geometry().slots,
                     .message_max = view.geometry().message_max,
                     .waiting = shm::waiting(view),
                     .counts = LocalSegments::counts(*mailbox),
                     .asleep = mailbox->sender->sleeper() != 0};
}

void ClientPort::sweep_orphans() {
  segments_.reclaim_everywhere([this](std::uint32_t writer) {
    return writer != kRouterWriter && !writers_.contains(writer);
  });
}

}  // namespace tims::io
