// Watches whether a task that shall work in real time does so: while it is in its loop it neither
// gives its CPU away nor touches memory that is not there yet. Waiting through the runtime
// (sleep_until_next(), messages) is what such a task is for, and no offence.
//
// The task itself only counts, without system calls; what it has found is looked at by the main
// thread, which knows names of functions.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "components/runtime/backtrace.h"
#include "components/runtime/logic/offences.h"
#include "components/runtime/perf_events.h"
#include "rack/priority_mutex.h"
#include "rack/proxies/generic.h"
#include "rack/text_log.h"
#include "tims/waiting.h"

namespace rack {

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
    Offence offence{};
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
  void hand_over(Offence offence, const Snapshot* snapshot);
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
  std::atomic<std::int64_t> lost_ = 0;  // offences that were not told of in time
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
  Unwinder unwinder_;

  mutable PriorityMutex mutex_;
  OffencePlaces places_;
};

}  // namespace rack
