// How a session finds its way to an address. Everything here happens once for each address, and
// again after something changed; the way of an ordinary message is target_for's first lines.
#include <sys/stat.h>

#include "client/session_core.h"
#include "os/clock.h"
#include "os/event_fd.h"
#include "os/futex.h"
#include "os/waker.h"

namespace tims {

using client::Answer;
using client::PeerSegment;
using client::Route;
using client::Target;

namespace {

using namespace std::chrono_literals;
// After a router's restart: how long its clients may take to come back before a mailbox that is
// not registered again counts as gone, and how often to ask meanwhile.
constexpr Duration kReturnGrace = 3s;
constexpr Duration kConfirmEvery = 100ms;

std::uint64_t inode_of(const os::File& file) {
  struct stat status {};
  return ::fstat(file.get(), &status) == 0 ? status.st_ino : 0;
}

}  // namespace

Result<Target*> SessionCore::resolve(Route& route) {
  const std::lock_guard lock(resolve_mutex_);
  Target* old = route.target.load(std::memory_order_acquire);
  if (old != nullptr && !old->sender.closed()) return old;  // another thread was faster
  auto answer = look_up(route.address);
  if (!answer) return answer.error();
  if (old != nullptr && !old->uplink) retire(*old);
  return install(route, *answer);
}

// A known mailbox, but a new router. Its owner may not have come back to the router yet: the
// mailbox is good as long as nobody says otherwise.
Result<Target*> SessionCore::confirm(Route& route, Target& target) {
  const Time now = os::now();
  const bool waiting = now < Time(Duration(route.next_check_ns.load(std::memory_order_relaxed)));
  if (waiting || !link_.connected()) return &target;
  const std::lock_guard lock(resolve_mutex_);
  route.next_check_ns.store((now + kConfirmEvery).time_since_epoch().count(),
                            std::memory_order_relaxed);
  const std::uint64_t connection = link_.connection();
  auto answer = look_up(route.address);
  if (!answer) return &target;
  const auto& found = std::get<wire::Found>(answer->record);
  if (found.local && !answer->files.empty() &&
      inode_of(answer->files.front()) == target.segment.inode()) {
    target.confirmed.store(connection, std::memory_order_relaxed);
    return &target;
  }
  if (!found.local && now - link_.connected_at() < kReturnGrace) return &target;
  if (!target.uplink) retire(target);
  return install(route, *answer);
}

Result<Answer> SessionCore::look_up(Address address) {
  auto answers = link_.exchange(wire::Lookup{{address}}, {}, 1);
  if (!answers) return answers.error();
  Answer& answer = answers->front();
  if (!std::holds_alternative<wire::Found>(answer.record))
    return Error(Errc::kVersion, "an unexpected answer");
  return std::move(answer);
}

Result<Target*> SessionCore::install(Route& route, Answer& answer) {
  const auto& found = std::get<wire::Found>(answer.record);
  auto target = found.local ? local_target(found, answer) : uplink();
  if (!target) return target.error();
  target.value()->confirmed.store(link_.connection(), std::memory_order_relaxed);
  route.target.store(*target, std::memory_order_release);
  return target;
}

Result<Target*> SessionCore::local_target(const wire::Found& found, Answer& answer) {
  const std::size_t files = found.has_waker ? 2 : 1;
  if (answer.files.size() != files) return Error(Errc::kVersion, "a descriptor is missing");
  auto segment = peer_segment(answer.files[0]);
  if (!segment) return segment.error();
  auto view = shm::MailboxView::open(segment.value()->bytes(), found.place.offset);
  if (!view) return view.error();
  segment.value()->use(found.place.offset);
  targets_.push_back(std::make_unique<Target>(*view, link_.welcome().writer, **segment));
  if (found.has_waker) targets_.back()->waker = std::move(answer.files[1]);
  return targets_.back().get();
}

Result<PeerSegment*> SessionCore::peer_segment(const os::File& memfd) {
  const std::uint64_t inode = inode_of(memfd);
  if (const auto known = peers_.find(inode); known != peers_.end()) return known->second;
  auto mapping = os::Mapping::of(memfd);
  if (!mapping) return mapping.error();
  segments_.push_back(std::make_unique<PeerSegment>(std::move(*mapping), inode));
  return peers_[inode] = segments_.back().get();
}

Result<Target*> SessionCore::uplink() {
  if (Target* open = uplink_.load(std::memory_order_acquire)) return open;
  auto answers = link_.exchange(wire::UplinkRequest{}, {}, 1);
  if (!answers) return answers.error();
  Answer& answer = answers->front();
  const auto* granted = std::get_if<wire::Uplink>(&answer.record);
  if (granted == nullptr || answer.files.size() != 2)
    return Error(Errc::kRefused, "the router gives no uplink");
  auto segment = peer_segment(answer.files[0]);
  if (!segment) return segment.error();
  auto view = shm::MailboxView::open(segment.value()->bytes(), granted->place.offset);
  if (!view) return view.error();
  segment.value()->use(granted->place.offset);
  targets_.push_back(std::make_unique<Target>(*view, link_.welcome().writer, **segment));
  targets_.back()->uplink = true;
  targets_.back()->waker = std::move(answer.files[1]);
  uplink_.store(targets_.back().get(), std::memory_order_release);
  return targets_.back().get();
}

void SessionCore::retire(Target& target) {
  target.segment.retire();
  if (target.segment.retired()) peers_.erase(target.segment.inode());
}

// Every kind wakes first and clears the sign after it, or both at once: a sender that dies in
// between leaves the owner woken, or the sign standing for the next sender. Which kind it is says
// the router, not the memory, which the owner can change: a waker is checked, a doorbell is the
// router's own.
void SessionCore::wake_sleeper(Target& target, std::uint32_t sleep) {
  shm::Word32& word = target.sender.view().header().sleep;
  if (!target.waker) return os::futex_clear_and_wake(*word.raw());
  target.uplink ? os::signal_event_fd(target.waker.get()) : os::wake(target.waker.get());
  word.compare_exchange(sleep, sleep & ~1U, std::memory_order_acq_rel);
}

}  // namespace tims
