#include "components/runtime/logic/real_time_records.h"

#include <algorithm>
#include <cstring>

#include <linux/perf_event.h>

namespace rack {

namespace {

// The rest of one record. Whatever sizes the record states, nothing behind its end is read.
class Cursor {
 public:
  Cursor(std::span<const std::byte> ring, std::uint64_t at, std::uint64_t end)
      : ring_(ring), at_(at), end_(end) {}

  bool copy(std::span<std::byte> to) {
    if (to.size() > left()) return false;
    const std::size_t from = at_ & (ring_.size() - 1);
    const std::size_t first = std::min(to.size(), ring_.size() - from);
    std::memcpy(to.data(), ring_.data() + from, first);
    std::memcpy(to.data() + first, ring_.data(), to.size() - first);
    at_ += to.size();
    return true;
  }
  template <typename Value>
  bool take(Value& value) {
    return copy(std::as_writable_bytes(std::span(&value, 1)));
  }
  bool skip(std::uint64_t size) {
    if (size > left()) return false;
    at_ += size;
    return true;
  }
  [[nodiscard]] std::uint64_t left() const { return end_ - at_; }

 private:
  std::span<const std::byte> ring_;
  std::uint64_t at_;
  std::uint64_t end_;
};

// Marks between the addresses give their context (user or kernel).
bool is_mark(std::uint64_t address) { return address >= PERF_CONTEXT_MAX; }

bool take_chain(Cursor& cursor, Snapshot& to) {
  std::uint64_t count = 0;
  if (!cursor.take(count) || count > cursor.left() / sizeof count) return false;
  for (; count > 0; --count) {
    std::uint64_t address = 0;
    if (!cursor.take(address)) return false;
    if (!is_mark(address) && to.chain_size < Snapshot::kChainMax)
      to.chain[to.chain_size++] = address;
  }
  return true;
}

bool take_registers(Cursor& cursor, std::uint32_t count, Snapshot& to) {
  std::uint64_t abi = PERF_SAMPLE_REGS_ABI_NONE;
  if (!cursor.take(abi)) return false;
  if (abi == PERF_SAMPLE_REGS_ABI_NONE) return true;
  if (count > Snapshot::kRegistersMax) return false;
  if (!cursor.copy(std::as_writable_bytes(std::span(to.registers).first(count)))) return false;
  to.register_count = count;
  return true;
}

// A block of fixed size, which may be filled in part.
bool take_stack(Cursor& cursor, Snapshot& to) {
  std::uint64_t room = 0;
  if (!cursor.take(room)) return false;
  if (room == 0) return true;
  if (room > cursor.left()) return false;
  const std::uint64_t kept = std::min<std::uint64_t>(room, Snapshot::kStackMax);
  if (!cursor.copy(std::span(to.stack).first(kept)) || !cursor.skip(room - kept)) return false;
  std::uint64_t filled = 0;
  if (!cursor.take(filled)) return false;
  to.stack_size = static_cast<std::uint32_t>(std::min(filled, kept));
  return true;
}

// A truncated sample is used as far as it goes.
void read_sample(Cursor cursor, const PerfLayout& layout, PerfRecord& record) {
  std::uint64_t id = 0;
  if (!cursor.take(id)) return;
  if (id == layout.fault_id) {
    record.kind = PerfRecord::Kind::kPageFault;
  } else if (id == layout.switch_id) {
    record.kind = PerfRecord::Kind::kSwitch;
  } else {
    return;
  }
  (void)(take_chain(cursor, record.snapshot) &&
         take_registers(cursor, layout.registers, record.snapshot) &&
         take_stack(cursor, record.snapshot));
}

void read_lost(Cursor cursor, PerfRecord& record) {
  std::uint64_t id = 0;
  if (cursor.take(id) && cursor.take(record.lost)) record.kind = PerfRecord::Kind::kLost;
}

constexpr std::string_view kCalledBy = " < ";

// Internals of std::vector and the like are less informative than their caller.
bool is_of_library(std::string_view name) {
  const std::size_t at = name.find("std::");
  return at != std::string_view::npos && at < name.find('<');
}

}  // namespace

bool read_record(std::span<const std::byte> ring, std::uint64_t& at, std::uint64_t end,
                 const PerfLayout& layout, PerfRecord& record) {
  record.kind = PerfRecord::Kind::kOther;
  record.preempted = false;
  record.snapshot.clear();
  if (end - at > ring.size()) return false;
  perf_event_header header{};
  Cursor whole(ring, at, end);
  if (!whole.take(header) || header.size < sizeof header ||
      header.size - sizeof header > whole.left())
    return false;
  const Cursor body(ring, at + sizeof header, at + header.size);
  at += header.size;
  if (header.type == PERF_RECORD_SAMPLE) {
    read_sample(body, layout, record);
  } else if (header.type == PERF_RECORD_LOST) {
    read_lost(body, record);
  } else if (header.type == PERF_RECORD_SWITCH &&
             (header.misc & PERF_RECORD_MISC_SWITCH_OUT) != 0) {
    record.kind = PerfRecord::Kind::kSwitchedOut;
    record.preempted = (header.misc & PERF_RECORD_MISC_SWITCH_OUT_PREEMPT) != 0;
  }
  return true;
}

bool ViolationPlaces::add(Violation violation, std::string_view text) {
  const auto known = std::ranges::find_if(places_, [&](const Place& place) {
    return place.violation == violation && place.text == text;
  });
  if (known != places_.end()) {
    ++known->count;
    return false;
  }
  if (places_.size() == kMax) return false;
  places_.push_back({violation, std::string(text), 1});
  return true;
}

std::vector<ViolationPlaces::Place> ViolationPlaces::worst(std::size_t max) const {
  std::vector<Place> sorted = places_;
  std::ranges::stable_sort(sorted, std::ranges::greater(), &Place::count);
  if (sorted.size() > max) sorted.resize(max);
  return sorted;
}

std::string place_text(std::span<const std::string> functions, std::string_view outermost,
                       std::size_t size_max) {
  std::string text;
  for (const std::string& function : functions) {
    const std::string_view name = without_parameters(function);
    if (name == outermost) break;
    if (!text.empty() && is_of_library(name)) continue;
    const std::size_t more = name.size() + (text.empty() ? 0 : kCalledBy.size());
    if (!text.empty() && text.size() + more > size_max) break;
    if (!text.empty()) text += kCalledBy;
    text += name;
  }
  text.resize(std::min(text.size(), size_max));
  return text;
}

std::string_view without_parameters(std::string_view function) {
  // "(anonymous namespace)" and "operator()" are parts of names: the last parentheses are the
  // parameters.
  const std::size_t last = function.rfind(')');
  if (last == std::string_view::npos) return function;
  int open = 0;
  for (std::size_t i = last + 1; i-- > 0;) {
    if (function[i] == ')') ++open;
    if (function[i] == '(' && --open == 0) {
      const bool names = i == 0 || function[i - 1] == ':' || function[i - 1] == ' ';
      return names ? function : function.substr(0, i);
    }
  }
  return function;
}

}  // namespace rack
