// Records that the kernel writes into the ring of perf_event_open(2): bytes become values. Pure.
#pragma once

#include <cstdint>
#include <span>

#include "components/runtime/logic/snapshot.h"

namespace rack {

// What the events were asked for; it decides what stands in a sample.
struct PerfLayout {
  std::uint64_t fault_id = 0;   // the kernel's name of the event "page fault"
  std::uint64_t switch_id = 0;  // of "context switch"
  std::uint32_t registers = 0;  // in each sample
};

struct PerfRecord {
  enum class Kind : std::uint8_t {
    kOther,
    kPageFault,    // with snapshot
    kSwitch,       // with snapshot; kSwitchedOut follows
    kSwitchedOut,  // says whether it was preempted
    kLost,         // so many records did not fit
  };
  Kind kind = Kind::kOther;
  bool preempted = false;
  std::uint64_t lost = 0;
  Snapshot snapshot;
};

// Reads the record at position `at` of the endless stream whose last bytes the ring holds, and
// moves `at` behind it. False: up to `end` there is no whole record; the rest is worthless. The
// ring's size is a power of two.
bool read_record(std::span<const std::byte> ring, std::uint64_t& at, std::uint64_t end,
                 const PerfLayout& layout, PerfRecord& record);

}  // namespace rack
