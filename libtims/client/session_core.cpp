#include "client/session_core.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

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

// Those that have another owner.
void remove_lost(Batch& batch, const wire::Opened& opened) {
  Batch rest;
  auto file = batch.files.begin();
  for (std::size_t i = 0; i < batch.open.entries.size(); ++i) {
    const wire::OpenEntry& entry = batch.open.entries[i];
    const bool stays = opened.entries[i].status != wire::OpenStatus::kAddressInUse;
    if (stays) rest.open.entries.push_back(entry);
    if (entry.has_waker && stays) rest.files.push_back(*file);
    if (entry.has_waker) ++file;
  }
  batch = std::move(rest);
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

// Where a router of this user is that was started without $XDG_RUNTIME_DIR. Anybody may make a
// folder in /tmp: only one's own counts.
std::optional<std::string> router_in_tmp() {
  const std::string folder = "/tmp/tims-" + std::to_string(::geteuid());
  const std::string path = folder + "/router.sock";
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) return std::nullopt;
  if (status.st_uid != ::geteuid() || ::access(path.c_str(), F_OK) != 0) return std::nullopt;
  return path;
}

}  // namespace

std::string default_router() {
  if (const char* given = std::getenv("TIMS_ROUTER"); given != nullptr && *given != 0) return given;
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR"); runtime != nullptr && *runtime != 0) {
    std::string path = std::string(runtime) + "/tims/router.sock";
    if (::access(path.c_str(), F_OK) == 0) return path;
  }
  if (auto path = router_in_tmp()) return *path;
  return "/run/tims/router.sock";
}

SessionCore::SessionCore(SessionOptions options, wire::Endpoint router)
    : options_(with_defaults(std::move(options))),
      link_({.router = std::move(router),
             .name = options_.name,
             .tcp_message_max = options_.tcp_message_max,
             .tcp_priority = options_.tcp_priority},
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
    // Whoever registers everything with the next router finds it there, or has not looked yet.
    const std::lock_guard registering(registering_mutex_);
    auto registered = register_segment(**segment);
    if (registered) {
      const std::lock_guard lock(own_mutex_);
      std::erase_if(own_, [](const auto& weak) { return weak.expired(); });
      own_.push_back(*segment);
      return segment;
    }
    if (!(registered.error() == Errc::kNoRouter)) return registered.error();
  }
}

// The router takes a record as a whole or not at all; with several, the earlier ones are undone.
// One that stands still is waited for: it is not asked twice.
Result<void> SessionCore::register_segment(OwnSegment& segment) {
  const int memfd = segment.memfd.get();
  if (auto offered = link_.exchange(wire::OfferSegment{segment.id}, {&memfd, 1}, 0); !offered)
    return offered.error();
  std::vector<Address> done;
  for (const Batch& batch : batches(segment)) {
    auto answers = link_.exchange(batch.open, batch.files, 1, kForever);
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

Result<void> SessionCore::greet(client::Greeting& greeting) {
  {
    const std::lock_guard registering(registering_mutex_);
    const std::lock_guard lock(own_mutex_);
    for (const auto& weak : own_) {
      const auto segment = weak.lock();
      if (!segment) continue;
      if (auto registered = register_again(greeting, *segment); !registered) return registered;
    }
  }
  return uplink_again(greeting);
}

// An address that has another owner by now is lost, and the others are not.
Result<void> SessionCore::register_again(client::Greeting& greeting, OwnSegment& segment) {
  const int memfd = segment.memfd.get();
  for (std::vector<Batch> left = batches(segment); !left.empty();) {
    Batch& batch = left.back();
    // Each time: after a refusal the router may have forgotten the memory.
    if (auto offered = greeting.tell(wire::OfferSegment{segment.id}, {&memfd, 1}); !offered)
      return Error(Errc::kNoRouter, offered.error().message());
    auto answer = greeting.ask(batch.open, batch.files);
    if (!answer) return answer.error();
    const auto* opened = std::get_if<wire::Opened>(&answer->record);
    if (opened == nullptr || opened->entries.size() != batch.open.entries.size())
      return Error(Errc::kVersion, "an unexpected answer");
    if (!all_ok(*opened)) {
      const Error why = opening_failed(*opened);
      if (!(why == Errc::kAddressInUse)) return why;
      event(SessionEvent::Kind::kMailboxLost, why.message());
      remove_lost(batch, *opened);
      if (!batch.open.entries.empty()) continue;
    }
    left.pop_back();
  }
  return {};
}

// Whoever sent through the uplink of the last router goes on without asking this one. The last
// word of a greeting: from now on the router may say something by itself.
Result<void> SessionCore::uplink_again(client::Greeting& greeting) {
  if (!uplink_wanted_) return {};
  auto grant = greeting.ask(wire::UplinkRequest{});
  if (!grant) return grant.error();
  const std::lock_guard lock(resolve_mutex_);
  (void)uplink_target(*grant);  // refused: who needs it asks once more, and is told why
  return {};
}

void SessionCore::lost() {
  const std::lock_guard lock(resolve_mutex_);
  leave_uplink();
}

void SessionCore::moved(Address address) { routes_.forget(address); }

void SessionCore::event(SessionEvent::Kind kind, const std::string& text) {
  if (options_.on_event) return options_.on_event({kind, text});
  if (kind != SessionEvent::Kind::kConnected)
    std::fprintf(stderr, "%s: %s\n", options_.name.c_str(), text.c_str());
}

}  // namespace tims
