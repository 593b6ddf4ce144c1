// What the kernel tells a thread about itself: each page fault and each switch to another thread,
// with the place where it was (perf_event_open(2)).
//
// The kernel writes into a ring that is read without a system call.
#pragma once

#include <cstdint>
#include <optional>

#include "components/runtime/logic/perf_records.h"
#include "os/file.h"

namespace rack {

class PerfEvents {
 public:
  // What is allowed here, from much to little.
  enum class Depth : std::uint8_t {
    kNothing,
    kFaultPlaces,  // places of page faults; switches are only counted
    kAllPlaces,
  };

  PerfEvents() = default;
  PerfEvents(const PerfEvents&) = delete;
  PerfEvents& operator=(const PerfEvents&) = delete;
  ~PerfEvents();

  // From now on, of the calling thread. kNothing: error() says why.
  Depth open();
  [[nodiscard]] const tims::Error& error() const { return error_; }

  // --- the thread itself

  void skip();  // all that is there
  // False: no more is there.
  bool next(PerfRecord& record);

 private:
  bool open_events(bool with_kernel);
  bool map_ring();
  void touch_ring();
  void close();

  tims::os::File faults_;    // writes into the ring
  tims::os::File switches_;  // into the same one
  PerfLayout layout_;
  void* memory_ = nullptr;  // the kernel's page, and the ring behind it
  std::uint64_t at_ = 0;
  tims::Error error_{tims::Errc::kSystem, ""};
};

}  // namespace rack
