// What a local client may ask for.
#include <algorithm>
#include <array>

#include <sys/resource.h>

#include "os/clock.h"
#include "router/io/client_port.h"
#include "router/io/describe.h"

namespace tims::io {

namespace {

// Segments that were offered, and no mailbox opened in them: an honest client opens one before it
// offers the next.
constexpr std::size_t kUnusedSegmentsMax = 16;
constexpr const char* kNoDescriptor =
    "the router has no file descriptor left for this program, which may use a quarter of them: "
    "open "
    "mailboxes together, or raise the router's limit (LimitNOFILE, ulimit -n)";

// Of the router's descriptors, for the memory and the wakers of one client.
std::size_t descriptors_for_one() {
  rlimit limit{};
  return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur / 4 : 0;
}

}  // namespace

bool ClientPort::handle(LocalClient& client, wire::Packet& packet, os::Received& received) {
  const std::uint32_t request = packet.request;
  const wire::Record& record = packet.record;
  if (const auto* r = std::get_if<wire::Hello>(&record)) return hello(client, request, *r);
  if (!client.id) return false;  // not a word before hello
  if (const auto* r = std::get_if<wire::OfferSegment>(&record)) return offer(client, *r, received);
  if (const auto* r = std::get_if<wire::Open>(&record)) return open(client, request, *r, received);
  if (const auto* r = std::get_if<wire::Close>(&record))
    return close_mailboxes(client, request, *r);
  if (const auto* r = std::get_if<wire::Lookup>(&record)) return look_up(client, request, *r);
  if (std::holds_alternative<wire::UplinkRequest>(record)) return grant_uplink(client, request);
  return false;  // a router's own word
}

bool ClientPort::hello(LocalClient& client, std::uint32_t request, const wire::Hello& hello) {
  if (client.id) return false;
  if (hello.version_min > wire::kLocalVersion || hello.version_max < wire::kLocalVersion) {
    const std::string text = "this router speaks version " + std::to_string(wire::kLocalVersion) +
                             " of the local protocol, the client " +
                             std::to_string(hello.version_min) + " to " +
                             std::to_string(hello.version_max) + ": update the older one";
    (void)send(client, request, wire::Refused{text});
    return false;
  }
  // Of a program that lost its connection, and is back before the end of that was seen.
  if (const auto former = writers_.find(hello.writer); former != writers_.end())
    drop_if_hung_up(former->second);
  const os::PeerCredentials who = os::peer_credentials(client.socket.get());
  client.id = router_.connect(now_, {.port = core::PortKind::kLocal,
                                     .token = client.token,
                                     .pid = static_cast<std::uint32_t>(who.pid),
                                     .uid = who.uid,
                                     .name = std::string_view(hello.name)});
  if (!client.id) {
    (void)send(client, request,
               wire::Refused{"as many clients as limits.clients allows: raise it"});
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

// The number it had with the former router, when nobody has it now: slots it is writing at this
// moment stay its own.
std::uint32_t ClientPort::writer_for(std::uint32_t wish) {
  const auto free = [this](std::uint32_t w) {
    return w != 0 && w < kRouterWriter && !writers_.contains(w);
  };
  if (free(wish)) return wish;
  do last_writer_ = (last_writer_ + 1) & shm::SlotWord::kMask24;
  while (!free(last_writer_));
  return last_writer_;
}

// Said twice, by a client that had to wait for long: the first one stands.
bool ClientPort::offer(LocalClient& client, const wire::OfferSegment& offer,
                       os::Received& received) {
  if (client.offered.contains(offer.segment)) return true;
  if (client.offered.size() >= client.mailboxes.size() + kUnusedSegmentsMax) return false;
  const bool has_room = client.offered.size() + client.wakers < descriptors_for_one();
  if (received.files.size() == 1 && has_room) {
    client.offered[offer.segment] = segments_.offer(std::move(received.files.front()));
    return true;
  }
  client.offered[offer.segment] = LocalSegments::kLost;
  return received.files_lost || !has_room;
}

// All of them or none.
bool ClientPort::open(LocalClient& client, std::uint32_t request, const wire::Open& open,
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
      status = open_one(client, entry, std::move(waker), opened.text);
    }
    ok = status == wire::OpenStatus::kOk;
  }
  if (!ok) {
    for (std::size_t i = 0; i + 1 < done; ++i) {
      close_mailbox(client, open.entries[i].address);
      opened.entries[i].status = wire::OpenStatus::kNotTried;
    }
    drop_unused(client);
  }
  return send(client, request, opened);
}

wire::OpenStatus ClientPort::open_one(LocalClient& client, const wire::OpenEntry& entry,
                                      os::File waker, std::string& text) {
  if (has_opened(client, entry)) return wire::OpenStatus::kOk;
  const auto offered = client.offered.find(entry.place.segment);
  if (offered == client.offered.end()) {
    text = "no such segment was offered";
    return wire::OpenStatus::kBadPlace;
  }
  if (offered->second == LocalSegments::kLost) {
    text = kNoDescriptor;
    return wire::OpenStatus::kTooMany;
  }
  auto handle =
      segments_.add_mailbox(offered->second, entry.place.offset, entry.address, std::move(waker));
  if (!handle) {
    text = entry.address.to_string(router_.settings().widths) + ": " + handle.error().message();
    return wire::OpenStatus::kBadPlace;
  }
  const wire::OpenStatus status = register_one(client, entry.address, *handle, text);
  if (status == wire::OpenStatus::kOk) {
    client.mailboxes[entry.address.raw()] = *handle;
    client.wakers += entry.has_waker ? 1 : 0;
    segments_.open_mailbox(*handle);
  } else {
    segments_.withdraw_mailbox(*handle);
  }
  return status;
}

bool ClientPort::has_opened(const LocalClient& client, const wire::OpenEntry& entry) const {
  const auto own = client.mailboxes.find(entry.address.raw());
  const auto offered = client.offered.find(entry.place.segment);
  if (own == client.mailboxes.end() || offered == client.offered.end()) return false;
  const LocalSegments::Mailbox* mailbox = segments_.find(own->second);
  return mailbox->segment == offered->second && mailbox->offset == entry.place.offset;
}

wire::OpenStatus ClientPort::register_one(LocalClient& client, Address address,
                                          LocalSegments::Handle handle, std::string& text) {
  if (const auto* entry = router_.find(address)) {
    const core::Client* owner = router_.client(entry->owner);
    if (owner != nullptr && owner->info.port == core::PortKind::kLocal && owner->id != client.id)
      drop_if_hung_up(owner->info.token);
  }
  using Status = core::Registration::Status;
  const core::Registration result = router_.register_mailbox(now_, client.id, address, handle);
  if (result.status == Status::kOk) return wire::OpenStatus::kOk;
  if (result.status == Status::kAddressInUse) {
    const core::Client* owner = router_.client(result.owner);
    text = address.to_string(router_.settings().widths) + " belongs to " +
           describe(owner == nullptr ? core::Party{} : owner->party());
    return wire::OpenStatus::kAddressInUse;
  }
  text = "more mailboxes than limits.mailboxes_per_client allows: raise it";
  return wire::OpenStatus::kTooMany;
}

bool ClientPort::close_mailboxes(LocalClient& client, std::uint32_t request,
                                 const wire::Close& close) {
  for (const Address address : close.addresses) close_mailbox(client, address);
  drop_unused(client);
  return send(client, request, wire::Closed{});
}

// Memory that no mailbox of the client lies in.
void ClientPort::drop_unused(LocalClient& client) {
  std::erase_if(client.offered, [this](const auto& entry) {
    segments_.drop_if_empty(entry.second);
    return !segments_.knows(entry.second);
  });
}

void ClientPort::close_mailbox(LocalClient& client, Address address) {
  const auto own = client.mailboxes.find(address.raw());
  if (own == client.mailboxes.end()) return;
  router_.remove_mailbox(now_, client.id, address);
  client.wakers -= segments_.mailbox(own->second).waker ? 1 : 0;
  segments_.remove_mailbox(own->second);
  client.mailboxes.erase(own);
}

bool ClientPort::look_up(LocalClient& client, std::uint32_t request, const wire::Lookup& lookup) {
  return std::ranges::all_of(lookup.addresses,
                             [&](Address address) { return found(client, request, address); });
}

const core::Table::Entry* ClientPort::find_local(Address address) const {
  if (address == kTextSink && router_.shares_texts()) return nullptr;
  const auto* entry = router_.find(address);
  const core::Client* owner = entry == nullptr ? nullptr : router_.client(entry->owner);
  return owner != nullptr && owner->info.port == core::PortKind::kLocal ? entry : nullptr;
}

bool ClientPort::found(LocalClient& client, std::uint32_t request, Address address) {
  const auto* entry = find_local(address);
  if (entry == nullptr) return send(client, request, wire::Found{address, false, {}, false});
  const LocalSegments::Mailbox& mailbox = segments_.mailbox(entry->handle);
  std::vector<int> files{segments_.memfd(mailbox.segment).get()};
  if (mailbox.waker) files.push_back(mailbox.waker.get());
  client.known.insert(mailbox.segment);
  return send(client, request,
              wire::Found{.address = address,
                          .local = true,
                          .place = {mailbox.segment, mailbox.offset},
                          .has_waker = static_cast<bool>(mailbox.waker)},
              files);
}

bool ClientPort::grant_uplink(LocalClient& client, std::uint32_t request) {
  if (!client.uplink) {
    auto uplink = Uplink::make(settings_.message_max);
    if (!uplink) return send(client, request, wire::Refused{uplink.error().message()});
    client.uplink = std::move(*uplink);
    client.doorbell_watch.emplace(loop_, client.uplink->doorbell().get(),
                                  [this, &client](Ready) { on_doorbell(client); });
  }
  const std::array files{client.uplink->memfd().get(), client.uplink->doorbell().get()};
  return send(client, request, wire::Uplink{}, files);
}

// A client whose socket takes no more answers does not read them: it asks without end, or stands
// still. Without its answers it is lost anyway. One that has gone meanwhile broke no rule.
bool ClientPort::send(LocalClient& client, std::uint32_t request, const wire::Record& record,
                      std::span<const int> files) {
  std::vector<std::byte> bytes;
  wire::encode({request, record}, bytes);
  const auto sent = os::send_record(client.socket.get(), bytes, files, false);
  return sent.ok() || sent.error() == Errc::kClosed;
}

}  // namespace tims::io
