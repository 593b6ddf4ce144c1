#include "router/core/statistics.h"

#include "router/core/types.h"

namespace tims::core {
namespace {

std::int64_t second_of(Time t) {
  return std::chrono::floor<std::chrono::seconds>(t.time_since_epoch()).count();
}

}  // namespace

std::string_view name(Role role) { return label(kRoles, role).name; }
std::string_view name(LinkKind kind) { return label(kLinkKinds, kind).name; }

std::string_view name(PathKind kind) { return label(kPathKinds, kind).name; }
std::string_view name(Compression compression) { return label(kCompressions, compression).name; }
std::string_view name(PortKind port) { return label(kPortKinds, port).name; }

std::string_view name(Outcome outcome) { return label(kOutcomes, outcome).name; }
std::string_view sentence(Outcome outcome) { return label(kOutcomes, outcome).sentence; }

std::string_view name(EventKind kind) { return label(kEventKinds, kind).name; }
std::string_view sentence(EventKind kind) { return label(kEventKinds, kind).sentence; }

std::string_view name(CloseReason reason) { return label(kCloseReasons, reason).name; }
std::string_view sentence(CloseReason reason) { return label(kCloseReasons, reason).sentence; }

const Event& EventLog::add(const Event& event) {
  ++last_;
  Event& kept = ring_[last_ % ring_.size()];
  kept = event;
  kept.sequence = last_;
  return kept;
}

Count MessageCounters::total(Outcome outcome) const {
  Count sum;
  for (const auto& port : counts_) {
    for (const auto& message_class : port) {
      const Count& count = message_class[static_cast<std::size_t>(outcome)];
      sum.messages += count.messages;
      sum.bytes += count.bytes;
    }
  }
  return sum;
}

void DropHistory::add(Time now, std::uint64_t messages) {
  const std::int64_t number = second_of(now);
  Second& second = seconds_[static_cast<std::size_t>(number) % seconds_.size()];
  if (second.number != number) second = {number, 0};
  second.drops += messages;
}

std::uint64_t DropHistory::last_minute(Time now) const {
  const std::int64_t oldest = second_of(now) - std::ssize(seconds_) + 1;
  std::uint64_t sum = 0;
  for (const Second& second : seconds_) {
    if (second.number >= oldest) sum += second.drops;
  }
  return sum;
}

}  // namespace tims::core
