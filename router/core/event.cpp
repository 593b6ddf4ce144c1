#include "router/core/event.h"

namespace tims::core {

const Event& EventLog::add(const Event& event) {
  ++last_;
  Event& kept = ring_[last_ % kCapacity];
  kept = event;
  kept.sequence = last_;
  return kept;
}

}  // namespace tims::core
