// Watches whether a task that shall work in real time does so: while it is in its loop it neither
// gives its CPU away nor touches memory that is not there yet. Waiting through the runtime
// (sleep_until_next(), messages) is what such a task is for, and no violation.
//
// The kernel writes each page fault and each switch to another thread into a ring, with the place
// where it was (perf_event_open(2)); the task reads the ring without system calls, and only counts.
// What it has found is looked at by the main thread, which knows names of functions.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "components/runtime/backtrace.h"
#include "components/runtime/logic/real_time_records.h"
#include "os/file.h"
#include "rack/priority_mutex.h"
#include "rack/proxies/generic.h"
#include "rack/text_log.h"
#include "tims/mailbox.h"

namespace rack {

// What the kernel tells the calling thread about itself.
class PerfEvents {
 public:
  PerfEvents() = default;
  PerfEvents(const PerfEvents&) = delete;
  PerfEvents& operator=(const PerfEvents&) = delete;
  ~PerfEvents();

  // From now on, of the calling thread: as much as is allowed here. kCounts: no places, and error()
  // says why.
  WatchDepth open();
  [[nodiscard]] const tims::Error& error() const { return error_; }

  // --- the thread itself

  void skip();  // all that is there
  // False: no more is there.
  bool next(PerfRecord& record);

 private:
  bool open_events(bool with_kernel);
  bool map_ring();
  void prefault_ring();
  void close();

  tims::os::File faults_;    // writes into the ring
  tims::os::File switches_;  // into the same one
  PerfLayout layout_;
  void* memory_ = nullptr;  // the kernel's page, and the ring behind it
  std::uint64_t at_ = 0;
  tims::Error error_{tims::Errc::kSystem, ""};
};

// Whether a task of that priority is watched; $RACK_WATCH = 1 watches every one, 0 none.
bool is_watched(int priority);

class RealTimeWatch final : private tims::WaitObserver {
 public:
  RealTimeWatch() = default;
  RealTimeWatch(const RealTimeWatch&) = delete;
  RealTimeWatch& operator=(const RealTimeWatch&) = delete;
  ~RealTimeWatch() override { stop(); }

  // --- the task that is watched

  void start(TextLog& log);
  void stop();

  // One pass of the loop.
  class Section {
   public:
    explicit Section(RealTimeWatch& watch) : watch_(watch) { watch_.enter(); }
    Section(const Section&) = delete;
    Section& operator=(const Section&) = delete;
    ~Section() { watch_.leave(); }

   private:
    RealTimeWatch& watch_;
  };

  // --- the main thread

  // Finds out where what was found is, for describe(); says once that there is something.
  void report(TextLog& log);

  // --- any thread

  [[nodiscard]] bool on() const { return depth() != WatchDepth::kOff; }
  void describe(RuntimeData& data) const;

 private:
  // What the task hands to the main thread.
  struct Found {
    Violation violation{};
    Snapshot snapshot;
  };
  static constexpr std::uint32_t kRing = 16;

  void enter();
  void leave();
  // A wait that is meant, also outside of sections.
  void begins() override;
  void ends() override;

  void open_section();
  void close_section();
  void count_usage();
  void note(const PerfRecord& record);
  void hand_over(Violation violation, const Snapshot* snapshot);
  std::string where(const Found& found);
  [[nodiscard]] WatchDepth depth() const { return depth_.load(std::memory_order_relaxed); }

  struct Usage {  // getrusage()
    std::int64_t blocked = 0;
    std::int64_t preempted = 0;
    std::int64_t page_faults = 0;
  };
  static Usage usage();

  // Written by the task only.
  std::atomic<WatchDepth> depth_ = WatchDepth::kOff;
  std::atomic<std::int64_t> loops_ = 0;
  std::atomic<std::int64_t> blocked_ = 0;
  std::atomic<std::int64_t> preempted_ = 0;
  std::atomic<std::int64_t> page_faults_ = 0;
  std::atomic<std::int64_t> lost_ = 0;  // violations that were not told of in time
  bool inside_ = false;
  PerfEvents events_;
  PerfRecord record_;
  Snapshot switch_;  // where a switch was, until it is known why
  bool switch_seen_ = false;
  Usage before_;

  // From the task to the main thread.
  std::array<Found, kRing> ring_{};
  std::atomic<std::uint32_t> put_ = 0;
  std::atomic<std::uint32_t> taken_ = 0;

  // The main thread.
  bool said_ = false;
  std::optional<Unwinder> unwinder_;  // made when there is something to look at

  mutable PriorityMutex mutex_;
  ViolationPlaces places_;
};

}  // namespace rack
