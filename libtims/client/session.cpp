#include "client/session.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include <sys/stat.h>
#include <unistd.h>

#include "client/mailbox.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/socket.h"
#include "os/wakeup.h"
#include "shm/layout.h"
#include "shm/receiver.h"
#include "tims/session.h"

namespace tims {

namespace {

using namespace std::chrono_literals;

SessionOptions with_defaults(SessionOptions options) {
  if (options.name.empty()) options.name = program_invocation_short_name;
  if (options.name.size() > wire::kNameMax) options.name.resize(wire::kNameMax);
  return options;
}

// Lays the mailboxes out one after another; returns the total size.
std::uint64_t place(std::span<const MailboxOptions> options, OwnSegment& segment) {
  std::uint64_t at = 0;
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
  const std::uint64_t bytes = place(options, *segment);
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

// Open records for the mailboxes that are not registered yet, as many in one record as it can hold.
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

// Removes the mailboxes that have another owner.
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

// The address is formatted by this program, which may know more class names than the router.
Error opening_failed(const wire::Opened& opened, const AddressWidths& widths) {
  for (const wire::OpenedEntry& entry : opened.entries) {
    if (entry.status == wire::OpenStatus::kOk || entry.status == wire::OpenStatus::kNotTried)
      continue;
    const bool in_use = entry.status == wire::OpenStatus::kAddressInUse;
    return {in_use ? Errc::kAddressInUse : Errc::kRefused,
            entry.address.to_string(widths) + " " + opened.text};
  }
  return {Errc::kRefused, opened.text};
}

bool all_ok(const wire::Opened& opened) {
  return std::ranges::all_of(opened.entries, [](const wire::OpenedEntry& entry) {
    return entry.status == wire::OpenStatus::kOk;
  });
}

// Path of a router of this user that was started without $XDG_RUNTIME_DIR. Any user can create a
// directory in /tmp: only one owned by this user is accepted.
std::optional<std::string> router_in_tmp() {
  const std::string folder = "/tmp/tims-" + std::to_string(::geteuid());
  const std::string path = folder + "/router.sock";
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) return std::nullopt;
  if (status.st_uid != ::geteuid() || ::access(path.c_str(), F_OK) != 0) return std::nullopt;
  return path;
}

// After a restart of the router: the time its clients have to reconnect before a mailbox that is
// not registered again counts as gone, and the interval of the look-ups during that time.
constexpr Duration kReturnGrace = 3s;
constexpr Duration kConfirmEvery = 100ms;

std::uint64_t inode_of(const os::File& file) {
  struct stat status {};
  return ::fstat(file.get(), &status) == 0 ? status.st_ino : 0;
}

}  // namespace

namespace client {

void PeerSegment::retire() {
  if (++retired_ < offsets_.size()) return;
  mapping_.replace([this](std::span<std::byte> fresh) {
    for (const std::uint64_t offset : offsets_)
      reinterpret_cast<shm::MailboxHeader*>(fresh.data() + offset)
          ->closed.store(1, std::memory_order_relaxed);
  });
}

Route& RouteTable::add(Address address) {
  const std::lock_guard lock(mutex_);
  if (Route* known = find(*table_.load(std::memory_order_relaxed), address)) return *known;
  if (2 * (routes_.size() + 1) > tables_.back()->cells.size())
    grow(2 * tables_.back()->cells.size());
  routes_.push_back(std::make_unique<Route>(address));
  put(*tables_.back(), routes_.back().get());
  return *routes_.back();
}

void RouteTable::forget(Address address) {
  if (Route* known = find(*table_.load(std::memory_order_acquire), address))
    known->target.store(nullptr, std::memory_order_release);
}

void RouteTable::put(Table& table, Route* route) {
  const std::size_t mask = table.cells.size() - 1;
  std::size_t i = std::hash<Address>{}(route->address) >> 32;
  while (table.cells[i & mask].load(std::memory_order_relaxed) != nullptr) ++i;
  table.cells[i & mask].store(route, std::memory_order_release);
}

// Other threads may still read the old table: it is kept until the session ends.
void RouteTable::grow(std::size_t size) {
  tables_.push_back(std::make_unique<Table>(size));
  for (const auto& route : routes_) put(*tables_.back(), route.get());
  table_.store(tables_.back().get(), std::memory_order_release);
}

}  // namespace client

using client::Answer;
using client::PeerSegment;
using client::Route;
using client::Target;

std::string default_router() {
  if (std::string given = os::environment("TIMS_ROUTER"); !given.empty()) return given;
  if (const std::string runtime = os::environment("XDG_RUNTIME_DIR"); !runtime.empty()) {
    std::string path = runtime + "/tims/router.sock";
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

Result<std::shared_ptr<OwnSegment>> SessionCore::open(std::span<const MailboxOptions> options,
                                                      const GoOn& go_on) {
  if (auto valid = check(options, link_.welcome().widths); !valid) return valid.error();
  auto segment = make_segment(options, options_.name);
  if (!segment) return segment.error();
  {
    const std::lock_guard lock(own_mutex_);
    segment.value()->id = ++last_segment_;
  }
  for (;;) {
    if (auto ready = link_.wait_connected(go_on); !ready) return ready.error();
    // With this lock, a reconnect either finds the new segment and registers it, or happens
    // afterwards.
    std::unique_lock registering(registering_mutex_, std::defer_lock);
    while (!registering.try_lock_for(client::RouterLink::kSlice))
      if (!go_on()) return client::ended_early();
    auto registered = register_segment(**segment, go_on);
    if (registered) {
      const std::lock_guard lock(own_mutex_);
      std::erase_if(own_, [](const auto& weak) { return weak.expired(); });
      own_.push_back(*segment);
      return segment;
    }
    if (!(registered.error() == Errc::kNoRouter)) return registered.error();
  }
}

// The router accepts a record as a whole or not at all; with several records, the earlier ones are
// undone. A router that does not respond is waited for: the record is not sent twice.
Result<void> SessionCore::register_segment(OwnSegment& segment, const GoOn& go_on) {
  const int memfd = segment.memfd.get();
  if (auto offered = link_.exchange(wire::OfferSegment{segment.id}, {&memfd, 1}, 0); !offered)
    return offered.error();
  std::vector<Address> done;
  for (const Batch& batch : batches(segment)) {
    for (const wire::OpenEntry& entry : batch.open.entries) done.push_back(entry.address);
    auto answers = link_.exchange(batch.open, batch.files, 1, go_on);
    if (!answers) {
      if (answers.error() == Errc::kTimeout) withdraw(done, Answered::kNo);
      return answers.error();
    }
    const auto* opened = std::get_if<wire::Opened>(&answers->front().record);
    if (opened == nullptr) return Error(Errc::kVersion, "an unexpected answer");
    if (!all_ok(*opened)) {
      withdraw(std::span(done).first(done.size() - batch.open.entries.size()));
      return opening_failed(*opened, link_.welcome().widths);
    }
  }
  return {};
}

void SessionCore::withdraw(std::span<const Address> addresses, Answered answered) {
  for (; !addresses.empty();) {
    const auto part = addresses.first(std::min(addresses.size(), wire::kBatchMax));
    (void)link_.exchange(wire::Close{{part.begin(), part.end()}}, {},
                         answered == Answered::kYes ? 1 : 0);
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

// A router answers a record after it has accepted all messages sent before. Messages that a crashed
// router had not accepted are kept for the next one.
Result<void> SessionCore::flush(Time deadline) {
  for (;;) {
    if (auto ready = link_.wait_connected(deadline); !ready) return ready;
    if (!uplink_wanted_) return {};  // no message was ever sent to another host
    const Duration rest = deadline == kNever ? kForever : deadline - os::now();
    auto answered = link_.exchange(wire::Close{}, {}, 1, std::max(rest, Duration::zero()));
    if (answered) return {};
    if (deadline != kNever && os::now() >= deadline)
      return Error(Errc::kTimeout, "the router has not taken all messages");
  }
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

// An address that another program owns now is lost; the other addresses are registered.
Result<void> SessionCore::register_again(client::Greeting& greeting, OwnSegment& segment) {
  const int memfd = segment.memfd.get();
  for (std::vector<Batch> left = batches(segment); !left.empty();) {
    Batch& batch = left.back();
    // Each time, because a refusal may have made the router forget the memory.
    if (auto offered = greeting.send(wire::OfferSegment{segment.id}, {&memfd, 1}); !offered)
      return Error(Errc::kNoRouter, offered.error().message());
    auto answer = greeting.ask(batch.open, batch.files);
    if (!answer) return answer.error();
    const auto* opened = std::get_if<wire::Opened>(&answer->record);
    if (opened == nullptr || opened->entries.size() != batch.open.entries.size())
      return Error(Errc::kVersion, "an unexpected answer");
    if (!all_ok(*opened)) {
      const Error why = opening_failed(*opened, link_.welcome().widths);
      if (!(why == Errc::kAddressInUse)) return why;
      event(SessionEvent::Kind::kMailboxLost, why.message());
      remove_lost(batch, *opened);
      if (!batch.open.entries.empty()) continue;
    }
    left.pop_back();
  }
  return {};
}

// If messages were sent through the uplink of the last router, the uplink is requested again. This
// is the last request of a greeting: afterwards the router may send records on its own.
Result<void> SessionCore::uplink_again(client::Greeting& greeting) {
  if (!uplink_wanted_) return {};
  auto grant = greeting.ask(wire::UplinkRequest{});
  if (!grant) return grant.error();
  std::size_t lost = 0;
  {
    const std::lock_guard lock(resolve_mutex_);
    // on refusal, the next sender requests it again and gets the reason
    (void)uplink_target(*grant);
    lost = std::exchange(not_taken_along_, 0);
  }
  if (lost > 0)
    event(SessionEvent::Kind::kMessagesLost,
          std::to_string(lost) + " messages that waited for the former router are lost");
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

// --- routes
//
// Determines where messages to an address go. This is done once for each address, and again after
// changes; an ordinary message needs only the first lines of target_for().

Result<Target*> SessionCore::resolve(Route& route) {
  Target* old = nullptr;
  {
    const std::lock_guard lock(resolve_mutex_);
    old = route.target.load(std::memory_order_acquire);
    if (old != nullptr && !old->sender.closed()) return old;  // another thread was faster
    // Known, and not on this host: use the uplink of this connection.
    if (old != nullptr && old->uplink) {
      if (uplink_ == nullptr || uplink_->sender.closed())
        return Error(Errc::kNoRouter, "the connection to the router is lost");
      point(route, uplink_);
      return uplink_;
    }
  }
  return ask_for_route(route, old);
}

// Waits for the router without preventing other threads from looking up their routes.
Result<Target*> SessionCore::ask_for_route(Route& route, Target* old) {
  const std::uint64_t connection = link_.connection();
  auto answer = ask(wire::Lookup{{route.address}});
  if (!answer) return answer.error();
  const auto* found = std::get_if<wire::Found>(&answer->record);
  if (found == nullptr) return Error(Errc::kVersion, "an unexpected answer");
  Answer grant;
  if (!found->local && !has_uplink()) {
    auto granted = ask(wire::UplinkRequest{});
    if (!granted) return granted.error();
    grant = std::move(*granted);
  }
  const std::lock_guard lock(resolve_mutex_);
  if (!link_.connected() || link_.connection() != connection)
    return Error(Errc::kNoRouter, "the router went away");
  Target* const now = route.target.load(std::memory_order_acquire);
  if (now != nullptr && now != old && !now->sender.closed()) return now;  // as above
  auto target = found->local ? local_target(*found, *answer, now) : uplink_target(grant);
  if (!target) return target.error();
  target.value()->confirmed.store(connection, std::memory_order_relaxed);
  point(route, *target);
  return target;
}

bool SessionCore::has_uplink() {
  const std::lock_guard lock(resolve_mutex_);
  return uplink_ != nullptr;
}

Result<Answer> SessionCore::ask(const wire::Record& question) {
  auto answers = link_.exchange(question, {}, 1);
  if (!answers) return answers.error();
  return std::move(answers->front());
}

// The mailbox is known, but the router is new, and the owner may not have reconnected yet. The
// mailbox is used until the router contradicts, so no sender waits for the answer.
Target* SessionCore::confirm(Route& route, Target& target) {
  if (target.uplink) {
    target.confirmed.store(link_.connection(), std::memory_order_relaxed);
    return &target;
  }
  const Time now = os::now();
  Time::rep next = route.next_check_ns.load(std::memory_order_relaxed);
  if (now < Time(Duration(next)) || !link_.connected()) return &target;
  if (route.next_check_ns.compare_exchange_strong(
          next, (now + kConfirmEvery).time_since_epoch().count(), std::memory_order_relaxed))
    link_.ask_later(route.address);
  return &target;
}

// The answer to the request of confirm().
void SessionCore::found(const wire::Found& found, Answer& answer) {
  const std::lock_guard lock(resolve_mutex_);
  Route& route = routes_.get(found.address);
  Target* const old = route.target.load(std::memory_order_acquire);
  if (old == nullptr || old->uplink) return;
  if (found.local) {
    const auto target = local_target(found, answer, old);
    if (!target) return;
    // The answer belongs to this connection, whose number is final once it is complete.
    target.value()->confirmed.store(link_.connection(), std::memory_order_relaxed);
    point(route, *target);
  } else if (os::now() - link_.connected_at() >= kReturnGrace) {
    point(route, uplink_);
  }
}

// Returns the known target if it is the same mailbox, even if its owner has marked it closed: an
// owner can do that at any time.
Result<Target*> SessionCore::local_target(const wire::Found& found, Answer& answer, Target* old) {
  const std::size_t files = found.has_waker ? 2 : 1;
  if (answer.files.size() != files) return Error(Errc::kVersion, "a descriptor is missing");
  if (old != nullptr && !old->uplink && old->segment.inode() == inode_of(answer.files[0]) &&
      old->offset == found.place.offset)
    return old;
  auto target = add_target(answer.files[0], found.place.offset);
  if (target && found.has_waker) target.value()->waker = std::move(answer.files[1]);
  return target;
}

Result<Target*> SessionCore::uplink_target(Answer& grant) {
  if (uplink_ != nullptr) return uplink_;
  if (const auto* no = std::get_if<wire::Refused>(&grant.record))
    return Error(Errc::kRefused, no->text);
  const auto* granted = std::get_if<wire::Uplink>(&grant.record);
  if (granted == nullptr || grant.files.size() != 2)
    return Error(Errc::kRefused, "the router gives no uplink");
  auto target = add_target(grant.files[0], granted->place.offset);
  if (!target) return target;
  target.value()->uplink = true;
  target.value()->waker = std::move(grant.files[1]);
  uplink_ = *target;
  uplink_wanted_ = true;
  if (client::Target* former = std::exchange(former_uplink_, nullptr)) {
    take_along(*former, *uplink_);
    retire(*former);
  }
  return target;
}

// Nobody reads the old uplink any more: its routes are switched to the new one, and its content is
// kept for that router. A sender that is writing to it now gets an error and sends again.
void SessionCore::leave_uplink() {
  if (uplink_ == nullptr) return;
  former_uplink_ = std::exchange(uplink_, nullptr);
  uplink_left_ = os::now();
  const shm::MailboxView& view = former_uplink_->sender.view();
  shm::condemn(view);
  shm::reclaim(view, [](std::uint32_t) { return true; });
}

// Messages that the former router had not accepted go to this one first. If the former router still
// runs and has only closed the connection, it takes messages from the same memory at the same time:
// each message goes to one of the two.
void SessionCore::take_along(Target& from, Target& to) {
  constexpr Duration kTooOld = 30s;  // as long as messages wait for a link, by default
  const bool too_old = os::now() >= uplink_left_ + kTooOld;
  shm::Receiver receiver(from.sender.view());
  while (const auto taken = receiver.take()) {
    std::array<std::byte, kHeaderSize> header;
    wire::encode_header(taken->header, header);
    if (too_old || !shm::taken(to.sender.put(header, taken->body, taken->header.priority)))
      ++not_taken_along_;
    receiver.release(taken->hint);
  }
  wake(to);
}

Result<Target*> SessionCore::add_target(const os::File& memfd, std::uint64_t offset) {
  const std::uint64_t inode = inode_of(memfd);
  const auto known = peers_.find(inode);
  std::unique_ptr<PeerSegment> fresh;
  if (known == peers_.end()) {
    auto mapping = os::Mapping::of(memfd);
    if (!mapping) return mapping.error();
    fresh = std::make_unique<PeerSegment>(std::move(*mapping), inode);
  }
  PeerSegment& segment = fresh ? *fresh : *known->second;
  auto view = shm::MailboxView::open(segment.bytes(), offset);
  if (!view) return view.error();
  if (fresh) {
    peers_[inode] = fresh.get();
    segments_.push_back(std::move(fresh));
  }
  segment.use(offset);
  targets_.push_back(std::make_unique<Target>(*view, link_.welcome().writer, segment, offset));
  return targets_.back().get();
}

// Switches the route to the new target. The old target loses its reference only now, because both
// may be in the same memory.
void SessionCore::point(Route& route, Target* to) {
  Target* const old = route.target.exchange(to, std::memory_order_acq_rel);
  if (old != nullptr && old != to && !old->uplink) retire(*old);
}

void SessionCore::retire(Target& target) {
  target.segment.retire();
  if (target.segment.retired()) peers_.erase(target.segment.inode());
}

// --- Session

Result<Session> Session::connect(SessionOptions options) {
  if (options.router.empty()) options.router = default_router();
  auto router = wire::parse_endpoint(options.router);
  if (!router) return router.error();
  constexpr std::uint32_t kMax = shm::kMessageMax;
  if (options.tcp_message_max < kHeaderSize || options.tcp_message_max > kMax)
    return Error(Errc::kInvalidArgument, "tcp_message_max is 16 bytes to 1 GiB");
  auto core = std::make_shared<SessionCore>(std::move(options), std::move(*router));
  if (auto connected = core->connect(); !connected) return connected.error();
  return Session(std::move(core));
}

Session::Session(std::shared_ptr<SessionCore> core) : core_(std::move(core)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

Result<Mailbox> Session::open(const MailboxOptions& options) {
  auto mailboxes = open(std::span(&options, 1));
  if (!mailboxes) return mailboxes.error();
  return std::move(mailboxes->front());
}

Result<std::vector<Mailbox>> Session::open(std::span<const MailboxOptions> options) {
  return open(options, [] { return true; });
}

Result<std::vector<Mailbox>> Session::open(std::span<const MailboxOptions> options,
                                           const GoOn& go_on) {
  auto segment = core_->open(options, go_on);
  if (!segment) return segment.error();
  std::vector<Mailbox> mailboxes;
  mailboxes.reserve(options.size());
  for (std::size_t i = 0; i < options.size(); ++i)
    mailboxes.push_back(Mailbox(std::make_shared<MailboxCore>(core_, *segment, i, options[i])));
  return mailboxes;
}

Result<void> Session::flush(Duration timeout) { return core_->flush(os::deadline_after(timeout)); }

bool Session::connected() const { return core_->connected(); }
Address Session::router() const { return core_->welcome().router; }
AddressWidths Session::address_widths() const { return core_->welcome().widths; }

}  // namespace tims
