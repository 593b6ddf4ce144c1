// How a session finds its way to an address. Everything here happens once for each address, and
// again after something changed; the way of an ordinary message is target_for's first lines.
#include <algorithm>
#include <string>

#include <sys/stat.h>

#include "client/session_core.h"
#include "os/clock.h"
#include "os/event_fd.h"
#include "os/futex.h"
#include "os/waker.h"
#include "shm/receiver.h"
#include "shm/reclaim.h"

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
  Target* old = nullptr;
  {
    const std::lock_guard lock(resolve_mutex_);
    old = route.target.load(std::memory_order_acquire);
    if (old != nullptr && !old->sender.closed()) return old;  // another thread was faster
    // Known, and not of this host: the way is the uplink of this connection.
    if (old != nullptr && old->uplink) {
      if (uplink_ == nullptr || uplink_->sender.closed())
        return Error(Errc::kNoRouter, "the connection to the router is lost");
      lead(route, uplink_);
      return uplink_;
    }
  }
  return ask_for_way(route, old);
}

// Waits for the router, and lets others have their ways meanwhile.
Result<Target*> SessionCore::ask_for_way(Route& route, Target* old) {
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
  lead(route, *target);
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

// A known mailbox, but a new router. Its owner may not have come back to the router yet: the
// mailbox is good as long as nobody says otherwise, and no sender waits for the answer.
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

// What confirm() has asked for.
void SessionCore::found(const wire::Found& found, Answer& answer) {
  const std::lock_guard lock(resolve_mutex_);
  Route& route = routes_.get(found.address);
  Target* const old = route.target.load(std::memory_order_acquire);
  if (old == nullptr || old->uplink) return;
  if (found.local) {
    const auto target = local_target(found, answer, old);
    if (!target) return;
    // The answer came on this connection, which is counted when it is complete.
    target.value()->confirmed.store(link_.connection(), std::memory_order_relaxed);
    lead(route, *target);
  } else if (os::now() - link_.connected_at() >= kReturnGrace) {
    lead(route, uplink_);
  }
}

// The one that is known already, when it is the same mailbox: also when its owner says that it is
// closed, which it can say as often as it likes.
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

// Nobody reads the old uplink any more: its routes look for the new one. What is in it waits for
// that, too; who is writing to it now is told so, and sends again.
void SessionCore::leave_uplink() {
  if (uplink_ == nullptr) return;
  former_uplink_ = std::exchange(uplink_, nullptr);
  uplink_left_ = os::now();
  const shm::MailboxView& view = former_uplink_->sender.view();
  shm::condemn(view);
  shm::reclaim(view, [](std::uint32_t) { return true; });
}

// What the former router had not taken goes to this one, before anything else does. A router that
// lives, and has only closed the connection, takes the same messages at the same time: each goes
// to one of the two.
void SessionCore::take_along(Target& from, Target& to) {
  constexpr Duration kTooOld = 30s;  // as long as messages wait for a link, by default
  const bool too_old = os::now() >= uplink_left_ + kTooOld;
  std::size_t lost = 0;
  shm::Receiver receiver(from.sender.view());
  while (const auto taken = receiver.take()) {
    shm::Claim claim;
    const Header& header = taken->header;
    const bool claimed =
        !too_old && shm::taken(to.sender.claim(header.length, header.priority, claim));
    if (claimed) {
      wire::encode_header(header, wire::HeaderBytes(claim.header, kHeaderSize));
      std::ranges::copy(taken->body, claim.body);
    }
    if (!claimed || to.sender.commit(claim) != shm::SendOutcome::kOk) ++lost;
    receiver.release(taken->hint);
  }
  wake(to);
  if (lost > 0)
    event(SessionEvent::Kind::kMessagesLost,
          std::to_string(lost) + " messages that waited for the former router are lost");
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

// From now on there. What was there before is counted out once, and only now: it may lie in the
// same memory.
void SessionCore::lead(Route& route, Target* to) {
  Target* const old = route.target.exchange(to, std::memory_order_acq_rel);
  if (old != nullptr && old != to && !old->uplink) retire(*old);
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
