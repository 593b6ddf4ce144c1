#include "components/runtime/logic/listeners.h"

#include <algorithm>

namespace rack {

Listeners::Listeners(std::size_t max) : max_(max) { listeners_.reserve(max); }

Listeners::Added Listeners::add(const tims::Header& request, tims::Address mailbox,
                                std::uint32_t reduction, tims::Time now) {
  return add({mailbox, request.priority, request.seq_nr, reduction, false, now});
}

Listeners::Added Listeners::add_once(const tims::Header& request, tims::Time now) {
  return add({request.src, request.priority, request.seq_nr, 1, true, now});
}

Listeners::Added Listeners::add(const Listener& wanted) {
  const auto known = std::ranges::find(listeners_, wanted.mailbox, &Listener::mailbox);
  if (known == listeners_.end()) {
    if (listeners_.size() == max_) return Added::kFull;
    listeners_.push_back(wanted);
    return Added::kNew;
  }
  known->reduction = wanted.reduction;
  known->once = wanted.once;
  known->requested = wanted.requested;
  // The answer to GET_NEXT_DATA is identified by its sequence number.
  if (wanted.once) {
    known->priority = wanted.priority;
    known->seq_nr = wanted.seq_nr;
  }
  return Added::kAgain;
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
}

std::span<Listener> Listeners::take_due(std::span<Listener> to) {
  if (++counter_ == 0) ++counter_;
  std::size_t n = 0;
  for (const Listener& listener : listeners_) {
    if (counter_ % listener.reduction == 0) to[n++] = listener;
  }
  std::erase_if(listeners_, &Listener::once);
  return to.first(n);
}

}  // namespace rack
