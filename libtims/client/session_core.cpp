#include "client/session_core.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>

#include <sys/stat.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/futex.h"
#include "os/unix_socket.h"
#include "shm/checked_view.h"

namespace tims {

namespace {

SessionOptions with_defaults(SessionOptions options) {
  if (options.name.empty()) options.name = program_invocation_short_name;
  if (options.name.size() > wire::kNameMax) options.name.resize(wire::kNameMax);
  return options;
}

// Lays the mailboxes out one behind the other; returns the size of all.
std::size_t place(std::span<const MailboxOptions> options, OwnSegment& segment) {
  std::size_t at = 0;
  for (const MailboxOptions& o : options) {
    segment.mailboxes.push_back({.address = o.address, .offset = at, .wake = {}});
    const auto bytes = shm::Geometry::of(o.slots, o.body_max + kHeaderSize).bytes;
    at += (bytes + shm::kMailboxAlign - 1) / shm::kMailboxAlign * shm::kMailboxAlign;
  }
  return at;
}

Result<void> check(std::span<const MailboxOptions> options, const AddressWidths& widths) {
  for (const MailboxOptions& o : options)
    if (o.body_max > shm::kMessageMax - kHeaderSize ||
        !shm::Geometry::valid(o.slots, o.body_max + kHeaderSize))
      return Error(Errc::kInvalidArgument, o.address.to_string(widths) +
                                               ": a mailbox has 1 to 65535 slots of at most 1 GiB");
  return {};
}

Result<std::shared_ptr<OwnSegment>> make_segment(std::span<const MailboxOptions> options,
                                                 const std::string& name) {
  auto segment = std::make_shared<OwnSegment>();
  const std::size_t bytes = place(options, *segment);
  auto memfd = os::make_memfd("tims-" + name, bytes);
  if (!memfd) return memfd.error();
  segment->memfd = std::move(*memfd);
  auto mapping = os::Mapping::of(segment->memfd);
  if (!mapping) return mapping.error();
  segment->mapping = std::move(*mapping);
  for (std::size_t i = 0; i < options.size(); ++i) {
    const MailboxOptions& o = options[i];
    OwnSegment::Mailbox& mailbox = segment->mailboxes[i];
    if (o.event_fd) {
      auto wake = os::make_wake_pair();
      if (!wake) return wake.error();
      mailbox.wake = std::move(*wake);
    }
    shm::MailboxView::create(segment->mapping.bytes(), mailbox.offset,
                             {.address = o.address,
                              .slots = o.slots,
                              .message_max = o.body_max + static_cast<std::uint32_t>(kHeaderSize),
                              .wake = o.event_fd ? shm::WakeKind::kSocket : shm::WakeKind::kFutex,
                              .owner_pid = static_cast<std::uint32_t>(::getpid())});
  }
  return segment;
}

// The Open records for what is still open: as many mailboxes as one record takes.
struct Batch {
  wire::Open open;
  std::vector<int> files;
};
std::vector<Batch> batches(const OwnSegment& segment) {
  std::vector<Batch> all;
  for (const OwnSegment::Mailbox& mailbox : segment.mailboxes) {
    if (!mailbox.open) continue;
    if (all.empty() || all.back().open.entries.size() == wire::kBatchMax ||
        all.back().files.size() == os::kRecordFilesMax)
      all.emplace_back();
    const os::File& waker = mailbox.wake.waker;
    const bool given = static_cast<bool>(waker);
    all.back().open.entries.push_back({mailbox.address, {segment.id, mailbox.offset}, given});
    if (given) all.back().files.push_back(waker.get());
  }
  return all;
}

Error opening_failed(const wire::Opened& opened) {
  for (const wire::OpenedEntry& entry : opened.entries) {
    if (entry.status == wire::OpenStatus::kOk || entry.status == wire::OpenStatus::kNotTried)
      continue;
    const bool in_use = entry.status == wire::OpenStatus::kAddressInUse;
    return {in_use ? Errc::kAddressInUse : Errc::kRefused, opened.text};
  }
  return {Errc::kRefused, opened.text};
}

bool all_ok(const wire::Opened& opened) {
  return std::ranges::all_of(opened.entries, [](const wire::OpenedEntry& entry) {
    return entry.status == wire::OpenStatus::kOk;
  });
}

}  // namespace

std::string default_router() {
  if (const char* given = std::getenv("TIMS_ROUTER"); given != nullptr && *given != 0) return given;
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR"); runtime != nullptr && *runtime != 0) {
    std::string path = std::string(runtime) + "/tims/router.sock";
    if (::access(path.c_str(), F_OK) == 0) return path;
  }
  return "/run/tims/router.sock";
}

SessionCore::SessionCore(SessionOptions options, wire::Endpoint router)
    : options_(with_defaults(std::move(options))),
      link_({.router = std::move(router),
             .name = options_.name,
             .tcp_message_max = options_.tcp_message_max},
            *this) {}

Result<void> SessionCore::connect() {
  link_.start();
  return link_.wait_connected(os::deadline_after(options_.timeout));
}

Result<std::shared_ptr<OwnSegment>> SessionCore::open(std::span<const MailboxOptions> options) {
  if (auto valid = check(options, link_.welcome().widths); !valid) return valid.error();
  auto segment = make_segment(options, options_.name);
  if (!segment) return segment.error();
  {
    const std::lock_guard lock(own_mutex_);
    segment.value()->id = ++last_segment_;
  }
  for (;;) {
    if (auto ready = link_.wait_connected(kNever); !ready) return ready.error();
    auto registered = register_segment(**segment);
    if (registered) break;
    if (!(registered.error() == Errc::kNoRouter)) return registered.error();
  }
  const std::lock_guard lock(own_mutex_);
  std::erase_if(own_, [](const auto& weak) { return weak.expired(); });
  own_.push_back(*segment);
  return segment;
}

// The router takes a record as a whole or not at all; with several, the earlier ones are undone.
Result<void> SessionCore::register_segment(OwnSegment& segment) {
  const int memfd = segment.memfd.get();
  if (auto offered = link_.exchange(wire::OfferSegment{segment.id}, {&memfd, 1}, 0); !offered)
    return offered.error();
  std::vector<Address> done;
  for (const Batch& batch : batches(segment)) {
    auto answers = link_.exchange(batch.open, batch.files, 1);
    if (!answers) return answers.error();
    const auto* opened = std::get_if<wire::Opened>(&answers->front().record);
    if (opened == nullptr) return Error(Errc::kVersion, "an unexpected answer");
    if (!all_ok(*opened)) {
      withdraw(done);
      return opening_failed(*opened);
    }
    for (const wire::OpenEntry& entry : batch.open.entries) done.push_back(entry.address);
  }
  return {};
}

void SessionCore::withdraw(std::span<const Address> addresses) {
  for (; !addresses.empty();) {
    const auto part = addresses.first(std::min(addresses.size(), wire::kBatchMax));
    (void)link_.exchange(wire::Close{{part.begin(), part.end()}}, {}, 1);
    addresses = addresses.subspan(part.size());
  }
}

void SessionCore::close(OwnSegment& segment, Address address) {
  {
    const std::lock_guard lock(own_mutex_);
    for (OwnSegment::Mailbox& mailbox : segment.mailboxes)
      if (mailbox.address == address) mailbox.open = false;
  }
  withdraw({&address, 1});
}

void SessionCore::greet(client::Greeting& greeting) {
  const std::lock_guard lock(own_mutex_);
  for (const auto& weak : own_)
    if (const auto segment = weak.lock()) register_again(greeting, *segment);
}

void SessionCore::register_again(client::Greeting& greeting, OwnSegment& segment) {
  const int memfd = segment.memfd.get();
  if (!greeting.tell(wire::OfferSegment{segment.id}, {&memfd, 1})) return;
  for (Batch& batch : batches(segment)) {
    auto answer = greeting.ask(batch.open, batch.files);
    if (!answer) return;
    const auto* opened = std::get_if<wire::Opened>(&answer->record);
    if (opened != nullptr && !all_ok(*opened))
      event(SessionEvent::Kind::kMailboxLost, opening_failed(*opened).message());
  }
}

void SessionCore::lost() {
  // Nobody reads the old uplink any more: its routes look for the new one.
  client::Target* old = uplink_.exchange(nullptr);
  if (old == nullptr) return;
  old->sender.view().header().closed.store(1, std::memory_order_release);
  const std::lock_guard lock(resolve_mutex_);
  retire(*old);
}

void SessionCore::moved(Address address) { routes_.forget(address); }

void SessionCore::event(SessionEvent::Kind kind, const std::string& text) {
  if (options_.on_event) return options_.on_event({kind, text});
  if (kind != SessionEvent::Kind::kConnected)
    std::fprintf(stderr, "%s: %s\n", options_.name.c_str(), text.c_str());
}

}  // namespace tims
