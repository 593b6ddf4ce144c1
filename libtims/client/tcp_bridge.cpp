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
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::client {
namespace {

namespace router_command = wire::router_command;

// Of what a router may send. What a mailbox does not take, it counts; only what no router would
// send ends the connection.
constexpr std::uint32_t kReceivedMax = 16U << 20;
constexpr std::size_t kScratchBytes = 64 << 10;
constexpr int kUplinkSlots = 256;
constexpr std::uint32_t kUplinkLongPlaces = 16;
constexpr std::size_t kWriteBytes = 64 << 10;
constexpr int kWritesPerTurn = 8;
// A router that asks and asks, and takes no answer, gets no more of them.
constexpr std::size_t kAnswersBytesMax = 1 << 20;

// No component has it. A router says that it is deleted, which shows that there is a router: with
// the connection alone it has not said anything yet.
constexpr Address kNobody(0xFFFFFFFF);

}  // namespace

TcpBridge::TcpBridge(os::File router, os::File session, Settings settings)
    : settings_(std::move(settings)),
      router_(std::move(router)),
      session_(std::move(session)),
      reader_(std::max(settings_.message_max, kReceivedMax)),
      scratch_(kScratchBytes),
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
  router_.reset();
}

// Sends what there is to send, and waits for the next thing to do.
bool TcpBridge::turn() {
  if (!write_router()) return false;
  const bool full = !written();
  const short router_events = static_cast<short>(full ? POLLIN | POLLOUT : POLLIN);
  const int doorbell = uplink_ && !full ? uplink_->doorbell().get() : -1;
  std::array<pollfd, 3> waits{
      {{session_.get(), POLLIN, 0}, {router_.get(), router_events, 0}, {doorbell, POLLIN, 0}}};
  if (::poll(waits.data(), waits.size(), more_ ? 0 : -1) < 0) return errno == EINTR;
  if (waits[2].revents != 0) os::drain_event_fd(doorbell);
  if (waits[1].revents != 0 && !read_router()) return false;
  return (waits[0].revents == 0 || read_session()) && !failed_;
}

// --- to the router

// What waits in the uplink, as far as the socket takes it, but not for ever. False: lost.
bool TcpBridge::write_router() {
  more_ = false;
  for (int writes = 0; writes < kWritesPerTurn; ++writes) {
    if (written() && !take_sent(kWriteBytes)) return true;
    if (!flush()) return false;
    if (!written()) return true;
  }
  more_ = true;
  return true;
}

// Appends what the session has sent, the most important first, until there is about as much of it.
// False: there was nothing; the doorbell rings for the next message.
bool TcpBridge::take_sent(std::size_t bytes_max, int messages_max) {
  if (!uplink_) return false;
  const std::size_t before = output_.size();
  for (int n = 0; n < messages_max && output_.size() - before < bytes_max;) {
    if (const auto taken = uplink_->receiver().take()) {
      const std::size_t at = output_.size();
      output_.resize(at + kHeaderSize);
      wire::encode_header(taken->header, wire::HeaderBytes(&output_[at], kHeaderSize));
      output_.insert(output_.end(), taken->body.begin(), taken->body.end());
      uplink_->release(*taken);
      ++n;
    } else if (uplink_->receiver().rest()) {
      break;
    }
  }
  return output_.size() > before;
}

bool TcpBridge::flush() {
  while (!written()) {
    const auto rest = std::span(output_).subspan(written_);
    const ssize_t n = ::send(router_.get(), rest.data(), rest.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0) return errno == EAGAIN || errno == EINTR;
    written_ += static_cast<std::size_t>(n);
  }
  output_.clear();
  written_ = 0;
  return true;
}

void TcpBridge::command(std::int8_t type, Address mailbox) {
  constexpr std::uint32_t kSize = kHeaderSize + sizeof(std::uint32_t);
  const Header header{.flags = flag::kNativeOrder, .type = type, .length = kSize};
  const std::size_t at = output_.size();
  output_.resize(at + kSize);
  wire::encode_header(header, wire::HeaderBytes(&output_[at], kHeaderSize));
  wire::HeaderWord::store(&output_[at + kHeaderSize], mailbox.raw(), std::endian::native);
}

// --- from the router

bool TcpBridge::read_router() {
  const std::span<std::byte> room = reader_.room();
  std::array<iovec, 2> pieces{iovec{room.data(), room.size()},
                              iovec{scratch_.data(), scratch_.size()}};
  msghdr message{};
  message.msg_iov = pieces.data() + (room.empty() ? 1 : 0);
  message.msg_iovlen = room.empty() ? 1 : 2;
  const ssize_t n = ::recvmsg(router_.get(), &message, MSG_DONTWAIT);
  if (n == 0) return false;
  if (n < 0) return errno == EAGAIN || errno == EINTR;
  const auto size = static_cast<std::size_t>(n);
  const std::size_t in_room = std::min(size, room.size());
  if (in_room > 0) reader_.advance(in_room);
  return take_messages(std::span(scratch_).first(size - in_room));
}

// False: nobody knows where the next message begins.
bool TcpBridge::take_messages(std::span<std::byte> chunk) {
  for (;;) {
    const wire::StreamReader::Item item = reader_.next(chunk);
    if (item.status == wire::StreamReader::Status::kNeedMore) return true;
    if (item.status != wire::StreamReader::Status::kMessage) return false;
    const auto body = item.message.subspan(kHeaderSize);
    if (item.header.dest == Address() && item.header.src == Address()) {
      on_router_command(item.header, body);
    } else {
      mailboxes_.deliver(item.header, body);
    }
  }
}

void TcpBridge::on_router_command(const Header& header, std::span<const std::byte> body) {
  switch (header.type) {
    case router_command::kLifesign: {
      if (output_.size() > kAnswersBytesMax) return;
      const std::size_t at = output_.size();
      output_.resize(at + kHeaderSize);
      wire::encode_header(wire::reply_to(header, type::kOk),
                          wire::HeaderBytes(&output_[at], kHeaderSize));
      return;
    }
    case router_command::kAddressWidths:
      widths_ = router_command::decode_widths(body).value_or(widths_);
      return;
    case type::kOk:
    case type::kError:
      return on_router_word(header.type == type::kOk);
    default:
      return;  // of another version
  }
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
                                    .widths = {}},  // on_router_word() knows
                      1});
    command(router_command::kLogin, {});
    command(router_command::kMailboxDeleteWithReply, kNobody);
  } else if (const auto* offer = std::get_if<wire::OfferSegment>(&record)) {
    if (files.size() != 1 || !mailboxes_.offer(offer->segment, files[0])) failed_ = true;
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

void TcpBridge::open(std::uint32_t request, const wire::Open& wish, std::vector<os::File> files) {
  auto opened = add_mailboxes(wish, std::move(files));
  if (!opened.text.empty()) return answer(request, opened);
  for (const wire::OpenEntry& entry : wish.entries)
    command(router_command::kMailboxInitWithReply, entry.address);
  asked_.push_back({request, std::move(opened), wish.entries.size()});
}

// All, or none and a text.
wire::Opened TcpBridge::add_mailboxes(const wire::Open& wish, std::vector<os::File> files) {
  wire::Opened opened;
  for (const wire::OpenEntry& entry : wish.entries)
    opened.entries.push_back({entry.address, wire::OpenStatus::kNotTried});
  auto waker = files.begin();
  for (std::size_t i = 0; i < wish.entries.size(); ++i) {
    const bool given = wish.entries[i].has_waker && waker != files.end();
    const auto added =
        mailboxes_.add(wish.entries[i], given ? std::move(*waker++) : os::File(), widths_);
    if (added) continue;
    opened.text = added.error().detail();
    opened.entries[i].status = added.error() == Errc::kAddressInUse
                                   ? wire::OpenStatus::kAddressInUse
                                   : wire::OpenStatus::kBadPlace;
    for (std::size_t j = 0; j < i; ++j) mailboxes_.remove(wish.entries[j].address);
    return opened;
  }
  return opened;
}

// A message that was sent before the mailbox was closed comes before that. One that the router
// gave to somebody else meanwhile is not ours to delete: the original would do it.
void TcpBridge::close(std::uint32_t request, const wire::Close& wish) {
  // As much as it holds, also when senders go on.
  if (uplink_) (void)take_sent(uplink_->size(), kUplinkSlots);
  std::size_t deleted = 0;
  for (const Address address : wish.addresses) {
    if (!mailboxes_.remove(address)) continue;
    command(router_command::kMailboxDeleteWithReply, address);
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

// OK or ERROR, to the first question that waits for one.
void TcpBridge::on_router_word(bool good) {
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
  if (auto* welcome = std::get_if<wire::Welcome>(&done.answer)) welcome->widths = widths_;
  answer(done.request, done.answer);
}

// All mailboxes of a record or none. How many are given back, which the router confirms: when the
// session has its answer, somebody else can have them.
std::size_t TcpBridge::settle(wire::Opened& opened) {
  const auto is_good = [](const wire::OpenedEntry& entry) {
    return entry.status == wire::OpenStatus::kOk;
  };
  const auto refused = std::ranges::find_if_not(opened.entries, is_good);
  if (refused == opened.entries.end()) return 0;
  opened.text = refused->address.to_string(widths_) +
                " belongs to somebody else, or the router at " + settings_.where +
                " has room for no more mailboxes";
  std::size_t deleted = 0;
  for (wire::OpenedEntry& entry : opened.entries) {
    mailboxes_.remove(entry.address);
    if (!is_good(entry)) continue;
    command(router_command::kMailboxDeleteWithReply, entry.address);
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
