#include "client/tcp_bridge.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include "os/socket.h"
#include "os/wakeup.h"
#include "tims/origin.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::client {

namespace {

namespace router_command = wire::router_command;

constexpr int kUplinkSlots = 256;
constexpr std::uint32_t kUplinkLongPlaces = 16;
constexpr std::size_t kWriteBytes = 64 << 10;
constexpr int kWritesPerTurn = 8;

// An address without a mailbox. The router confirms its deletion, which proves that it is a RACK
// router: the TCP connection alone does not.
constexpr Address kNobody(0xFFFFFFFF);

}  // namespace

TcpBridge::TcpBridge(TcpClient router, os::File session, Settings settings)
    : settings_(std::move(settings)),
      router_(std::move(router)),
      session_(std::move(session)),
      thread_([this] { run(); }) {}

TcpBridge::~TcpBridge() { thread_.join(); }

void TcpBridge::run() {
  ::pthread_setname_np(::pthread_self(), "tims-tcp");
  const sched_param priority{.sched_priority = settings_.priority};
  if (priority.sched_priority > 0)
    (void)::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
  while (turn()) {
  }
  session_.reset();
  router_.socket().reset();
}

// Sends what is pending, and waits for the next event.
bool TcpBridge::turn() {
  if (!write_router()) return false;
  const bool full = !router_.protocol().unsent().empty();
  const short router_events = static_cast<short>(full ? POLLIN | POLLOUT : POLLIN);
  const int doorbell = uplink_ && !full ? uplink_->doorbell().get() : -1;
  std::array<pollfd, 3> waits{{{session_.get(), POLLIN, 0},
                               {router_.socket().get(), router_events, 0},
                               {doorbell, POLLIN, 0}}};
  if (::poll(waits.data(), waits.size(), more_ ? 0 : -1) < 0) return errno == EINTR;
  if (waits[2].revents != 0) os::drain_event_fd(doorbell);
  if (waits[1].revents != 0 && !read_router()) return false;
  return (waits[0].revents == 0 || read_session()) && !failed_;
}

// --- to the router

// Sends messages of the uplink while the socket accepts them, up to a limit per turn. False:
// connection lost.
bool TcpBridge::write_router() {
  more_ = false;
  for (int writes = 0; writes < kWritesPerTurn; ++writes) {
    if (router_.protocol().unsent().empty() && !take_sent(kWriteBytes)) return true;
    if (const auto flushed = router_.flush(); !flushed) return flushed.error() == Errc::kEmpty;
  }
  more_ = true;
  return true;
}

// Appends the session's messages, the most important first, up to about the given size. False:
// there was none, and the doorbell is armed for the next message.
bool TcpBridge::take_sent(std::size_t bytes_max, int messages_max) {
  if (!uplink_) return false;
  std::size_t bytes = 0;
  for (int n = 0; n < messages_max && bytes < bytes_max;) {
    if (const auto taken = uplink_->receiver().take()) {
      router_.protocol().put(taken->header, taken->body);
      uplink_->release(*taken);
      bytes += taken->header.length;
      ++n;
    } else if (uplink_->receiver().rest()) {
      break;
    }
  }
  return bytes > 0;
}

// --- from the router

// False: connection lost, or the beginning of the next message is unknown.
bool TcpBridge::read_router() {
  const auto got = router_.read([this](const Header& header, std::span<const std::byte> body) {
    if (!wire::is_router_message(header)) return deliver(header, body);
    if (header.type == type::kOk || header.type == type::kError)
      on_router_reply(header.type == type::kOk);
  });
  return got || got.error() == Errc::kEmpty;
}

// Delivers to the receiver's mailbox if it has room; the mailbox counts what it does not accept.
void TcpBridge::deliver(const Header& header, std::span<const std::byte> body) {
  const auto found = mailboxes_.find(header.dest);
  if (found == mailboxes_.end()) return;  // closed a moment ago
  std::array<std::byte, kHeaderSize> bytes;
  wire::encode_header(marked_foreign(header, true), bytes);
  (void)memory_.deliver(found->second, bytes, body, header.priority);
}

// --- to the session

bool TcpBridge::read_session() {
  std::vector<std::byte> buffer(wire::kRecordBytesMax);
  auto received = os::receive_record(session_.get(), buffer, false);
  if (!received) return received.error() == Errc::kEmpty;
  if (received->size == 0) return false;
  const auto decoded = wire::decode(std::span(buffer).first(received->size));
  if (!decoded.packet) return false;
  on_record(decoded.packet->request, decoded.packet->record, std::move(received->files));
  return true;
}

void TcpBridge::on_record(std::uint32_t request, const wire::Record& record,
                          std::vector<os::File> files) {
  if (std::holds_alternative<wire::Hello>(record)) {
    asked_.push_back({request,
                      wire::Welcome{.writer = kTcpWriter,
                                    .router = Address(),
                                    .message_max = settings_.message_max,
                                    .widths = {}},  // set in on_router_reply()
                      1});
    router_.protocol().put_command(router_command::kLogin, {});
    router_.protocol().put_command(router_command::kMailboxDeleteWithReply, kNobody);
  } else if (const auto* offer = std::get_if<wire::OfferSegment>(&record)) {
    if (!this->offer(offer->segment, std::move(files))) failed_ = true;
  } else if (const auto* opening = std::get_if<wire::Open>(&record)) {
    open(request, *opening, std::move(files));
  } else if (const auto* closing = std::get_if<wire::Close>(&record)) {
    close(request, *closing);
  } else if (const auto* lookup = std::get_if<wire::Lookup>(&record)) {
    for (const Address address : lookup->addresses)
      answer(request, wire::Found{.address = address, .local = false});
  } else if (std::holds_alternative<wire::UplinkRequest>(record)) {
    grant_uplink(request);
  }
}

bool TcpBridge::offer(std::uint64_t segment, std::vector<os::File> files) {
  if (files.size() != 1) return false;
  os::ClientMemory::SegmentId& known = offered_[segment];
  // else it was offered twice
  if (!memory_.knows(known)) known = memory_.offer(std::move(files[0]));
  return true;
}

void TcpBridge::open(std::uint32_t request, const wire::Open& message,
                     std::vector<os::File> files) {
  auto opened = add_mailboxes(message, std::move(files));
  if (!opened.text.empty()) return answer(request, opened);
  for (const wire::OpenEntry& entry : message.entries)
    router_.protocol().put_command(router_command::kMailboxInitWithReply, entry.address);
  asked_.push_back({request, std::move(opened), message.entries.size()});
}

// All mailboxes, or none and a text.
wire::Opened TcpBridge::add_mailboxes(const wire::Open& message, std::vector<os::File> files) {
  wire::Opened opened;
  for (const wire::OpenEntry& entry : message.entries)
    opened.entries.push_back({entry.address, wire::OpenStatus::kNotTried});
  auto waker = files.begin();
  for (std::size_t i = 0; i < message.entries.size(); ++i) {
    const bool given = message.entries[i].has_waker && waker != files.end();
    const auto added = add_mailbox(message.entries[i], given ? std::move(*waker++) : os::File());
    if (added) continue;
    const bool in_use = added.error() == Errc::kAddressInUse;
    opened.text = (in_use ? "" : "is not registered: ") + added.error().detail();
    opened.entries[i].status =
        in_use ? wire::OpenStatus::kAddressInUse : wire::OpenStatus::kBadPlace;
    for (std::size_t j = 0; j < i; ++j) remove_mailbox(message.entries[j].address);
    return opened;
  }
  return opened;
}

Result<void> TcpBridge::add_mailbox(const wire::OpenEntry& entry, os::File waker) {
  if (mailboxes_.contains(entry.address))
    return Error(Errc::kAddressInUse, "belongs to this session");
  const auto offered = offered_.find(entry.place.segment);
  const auto segment = offered == offered_.end() ? os::ClientMemory::kLost : offered->second;
  auto handle = memory_.add_mailbox(segment, entry.place.offset, entry.address, std::move(waker));
  if (!handle) return handle.error();
  mailboxes_[entry.address] = *handle;
  return {};
}

bool TcpBridge::remove_mailbox(Address address) {
  const auto found = mailboxes_.find(address);
  if (found == mailboxes_.end()) return false;
  const auto segment = memory_.mailbox(found->second).segment;
  memory_.withdraw_mailbox(found->second);
  memory_.drop_if_empty(segment);
  if (!memory_.knows(segment))
    std::erase_if(offered_, [&](const auto& offered) { return offered.second == segment; });
  mailboxes_.erase(found);
  return true;
}

// Messages sent before the mailbox was closed are forwarded first. An address that the router has
// given to another client in the meantime must not be deleted: the original router would delete it.
void TcpBridge::close(std::uint32_t request, const wire::Close& message) {
  // At most its present capacity, even if senders continue.
  if (uplink_) (void)take_sent(uplink_->size(), kUplinkSlots);
  std::size_t deleted = 0;
  if (message.addresses.empty()) {  // asks whether all messages have arrived
    router_.protocol().put_command(router_command::kMailboxDeleteWithReply, kNobody);
    ++deleted;
  }
  for (const Address address : message.addresses) {
    if (!remove_mailbox(address)) continue;
    router_.protocol().put_command(router_command::kMailboxDeleteWithReply, address);
    ++deleted;
  }
  if (deleted == 0) return answer(request, wire::Closed{});
  asked_.push_back({request, wire::Closed{}, deleted});
}

void TcpBridge::grant_uplink(std::uint32_t request) {
  if (!uplink_) {
    auto made = os::Uplink::make("tims-tcp-uplink", {.slots = kUplinkSlots,
                                                     .long_places = kUplinkLongPlaces,
                                                     .message_max = settings_.message_max});
    if (!made) return answer(request, wire::Refused{made.error().message()});
    uplink_ = std::move(*made);
  }
  answer(request, wire::Uplink{}, std::array{uplink_->memfd().get(), uplink_->doorbell().get()});
}

// OK or ERROR, for the oldest pending request.
void TcpBridge::on_router_reply(bool good) {
  if (asked_.empty()) return;
  Asked& first = asked_.front();
  auto* opened = std::get_if<wire::Opened>(&first.answer);
  if (opened != nullptr && !first.undone)
    opened->entries[opened->entries.size() - first.missing].status =
        good ? wire::OpenStatus::kOk : wire::OpenStatus::kAddressInUse;
  if (--first.missing > 0) return;
  Asked done = std::move(first);
  asked_.pop_front();
  opened = std::get_if<wire::Opened>(&done.answer);
  if (opened != nullptr && !done.undone) done.missing = settle(*opened);
  if (done.missing > 0) {
    done.undone = true;
    asked_.push_back(std::move(done));
    return;
  }
  if (auto* welcome = std::get_if<wire::Welcome>(&done.answer)) welcome->widths = widths();
  answer(done.request, done.answer);
}

// Opens all mailboxes of a record or none. Returns how many are deleted again; the router confirms
// each, so that their addresses are free when the session gets its answer.
std::size_t TcpBridge::settle(wire::Opened& opened) {
  const auto is_good = [](const wire::OpenedEntry& entry) {
    return entry.status == wire::OpenStatus::kOk;
  };
  const auto refused = std::ranges::find_if_not(opened.entries, is_good);
  if (refused == opened.entries.end()) return 0;
  opened.text = "belongs to somebody else, or the router at " + settings_.where +
                " has room for no more mailboxes";
  std::size_t deleted = 0;
  for (wire::OpenedEntry& entry : opened.entries) {
    remove_mailbox(entry.address);
    if (!is_good(entry)) continue;
    router_.protocol().put_command(router_command::kMailboxDeleteWithReply, entry.address);
    entry.status = wire::OpenStatus::kNotTried;
    ++deleted;
  }
  return deleted;
}

void TcpBridge::answer(std::uint32_t request, const wire::Record& record,
                       std::span<const int> files) {
  std::vector<std::byte> bytes;
  wire::encode({request, record}, bytes);
  if (!os::send_record(session_.get(), bytes, files, false)) failed_ = true;
}

}  // namespace tims::client
