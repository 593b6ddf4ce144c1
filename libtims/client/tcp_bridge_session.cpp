// TcpBridge, the part that answers the session.
#include <algorithm>
#include <array>

#include "client/tcp_bridge.h"
#include "os/unix_socket.h"
#include "wire/router_commands.h"

namespace tims::client {

namespace {

namespace router_command = wire::router_command;

// No component has it. A router says that it is deleted, which shows that there is a router: with
// the connection alone it has not said anything yet.
constexpr Address kNobody(0xFFFFFFFF);

}  // namespace

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
  if (uplink_) uplink_->take_all(output_);
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
    auto made = TcpUplink::make(settings_.message_max);
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
  if (opened != nullptr)
    opened->entries[opened->entries.size() - first.missing].status =
        good ? wire::OpenStatus::kOk : wire::OpenStatus::kAddressInUse;
  if (--first.missing > 0) return;
  if (opened != nullptr) settle(*opened);
  if (auto* welcome = std::get_if<wire::Welcome>(&first.answer)) welcome->widths = widths_;
  answer(first.request, first.answer);
  asked_.pop_front();
}

// All mailboxes of a record or none.
void TcpBridge::settle(wire::Opened& opened) {
  const auto is_good = [](const wire::OpenedEntry& entry) {
    return entry.status == wire::OpenStatus::kOk;
  };
  const auto refused = std::ranges::find_if_not(opened.entries, is_good);
  if (refused == opened.entries.end()) return;
  opened.text = refused->address.to_string(widths_) +
                " belongs to somebody else, or the router at " + settings_.where +
                " has room for no more mailboxes";
  for (wire::OpenedEntry& entry : opened.entries) {
    mailboxes_.remove(entry.address);
    if (!is_good(entry)) continue;
    command(router_command::kMailboxDelete, entry.address);
    entry.status = wire::OpenStatus::kNotTried;
  }
}

void TcpBridge::answer(std::uint32_t request, const wire::Record& record,
                       std::span<const int> files) {
  std::vector<std::byte> bytes;
  wire::encode({request, record}, bytes);
  if (!os::send_record(session_.get(), bytes, files, false)) failed_ = true;
}

}  // namespace tims::client
