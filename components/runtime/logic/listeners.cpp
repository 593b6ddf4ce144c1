#include "components/runtime/logic/listeners.h"

#include <algorithm>
#include <utility>

namespace rack {

Listeners::Listeners(std::size_t max) : max_(max) { listeners_.reserve(max); }

Listeners::Added Listeners::add(const tims::Header& request, tims::Address source,
                                tims::Address mailbox, std::uint32_t reduction, tims::Time now) {
  return add({mailbox, source, request.priority, request.seq_nr, reduction, false, now});
}

Listeners::Added Listeners::add_once(const tims::Header& request, tims::Address source,
                                     tims::Time now) {
  return add({request.src, source, request.priority, request.seq_nr, 1, true, now});
}

std::span<Listener> Listeners::take_rare(std::span<Listener> to) {
  if (std::exchange(rare_taken_, true)) return {};
  std::size_t n = 0;
  for (const Listener& listener : listeners_) {
    if (!listener.once && (counter_ == 0 || counter_ % listener.reduction != 0)) to[n++] = listener;
  }
  return to.first(n);
}

std::optional<Listener> Listeners::make_place(tims::Address source) {
  const Listener* gives = nullptr;
  std::size_t most = places_of(source) + 1;
  for (const Listener& listener : listeners_) {
    const std::size_t places = places_of(listener.source);
    if (places < most || (gives == nullptr && places == most)) continue;
    most = places;
    gives = &listener;
  }
  if (gives == nullptr) return std::nullopt;
  const Listener given = *gives;
  remove(given.mailbox);
  return given;
}

std::size_t Listeners::places_of(tims::Address source) const {
  return static_cast<std::size_t>(std::ranges::count(listeners_, source, &Listener::source));
}

Listeners::Added Listeners::add(const Listener& wanted) {
  const auto known = std::ranges::find(listeners_, wanted.mailbox, &Listener::mailbox);
  if (known == listeners_.end()) {
    if (listeners_.size() == max_) return Added::kFull;
    listeners_.push_back(wanted);
    return Added::kNew;
  }
  const bool is_changed = std::exchange(known->reduction, wanted.reduction) != wanted.reduction;
  known->once = wanted.once;
  known->requested = wanted.requested;
  // The answer to GET_NEXT_DATA is identified by its sequence number.
  if (wanted.once) {
    known->priority = wanted.priority;
    known->seq_nr = wanted.seq_nr;
  }
  return is_changed ? Added::kChanged : Added::kAgain;
}

bool Listeners::remove(tims::Address mailbox) {
  return std::erase_if(listeners_, [&](const Listener& l) { return l.mailbox == mailbox; }) > 0;
}

bool Listeners::remove_gone(tims::Address mailbox, tims::Time now) {
  return std::erase_if(listeners_, [&](const Listener& l) {
           return l.mailbox == mailbox && now - l.requested >= kReportMayBeOld;
         }) > 0;
}

void Listeners::clear() {
  listeners_.clear();
  counter_ = 0;
  rare_taken_ = false;
}

std::span<Listener> Listeners::take_due(std::span<Listener> to) {
  if (++counter_ == 0) ++counter_;
  rare_taken_ = false;
  std::size_t n = 0;
  for (const Listener& listener : listeners_) {
    if (counter_ % listener.reduction == 0) to[n++] = listener;
  }
  std::erase_if(listeners_, &Listener::once);
  return to.first(n);
}

}  // namespace rack
