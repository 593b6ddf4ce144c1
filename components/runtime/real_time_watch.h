// Checks that a real-time task works in real time: while it is in its loop it neither blocks nor
// touches memory that is not resident. Waiting through the runtime (sleep_until_next(), messages)
// is intended and not a violation.
//
// The kernel writes each page fault and each context switch with its location into a ring
// (perf_event_open(2)); the task reads the ring without system calls, and only counts. The main
// thread resolves the locations to function names.
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

// Kernel events of the calling thread.
class PerfEvents {
 public:
  PerfEvents() = default;
  PerfEvents(const PerfEvents&) = delete;
  PerfEvents& operator=(const PerfEvents&) = delete;
  ~PerfEvents();

  // Starts recording events of the calling thread, as far as permitted. kCounts: no locations;
  // error() is the reason.
  WatchDepth open();
  [[nodiscard]] const tims::Error& error() const { return error_; }

  // --- called by the thread itself

  void skip();  // drops all records
  // False: there are no more records.
  bool next(PerfRecord& record);

 private:
  bool open_events(bool with_kernel);
  bool map_ring();
  void prefault_ring();
  void close();

  tims::os::File faults_;    // writes into the ring
  tims::os::File switches_;  // into the same one
  PerfLayout layout_;
  void* memory_ = nullptr;  // control page of the kernel, followed by the ring
  std::uint64_t at_ = 0;
  tims::Error error_{tims::Errc::kSystem, ""};
};

// Whether a task of that priority is watched; RACK_WATCH=1 watches every task, RACK_WATCH=0 none.
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

  // Resolves the locations of new violations, for describe(); logs the first one.
  void report(TextLog& log);

  // --- any thread

  [[nodiscard]] bool on() const { return depth() != WatchDepth::kOff; }
  void describe(RuntimeData& data) const;

 private:
  // A violation passed from the task to the main thread.
  struct Found {
    Violation violation{};
    Snapshot snapshot;
  };
  static constexpr std::uint32_t kRing = 16;

  void enter();
  void leave();
  // An intended wait, also outside of sections.
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
  std::atomic<std::int64_t> lost_ = 0;  // violations that did not fit into the ring
  bool inside_ = false;
  PerfEvents events_;
  PerfRecord record_;
  Snapshot switch_;  // location of a switch until its kind is known
  bool switch_seen_ = false;
  Usage before_;

  // From the task to the main thread.
  std::array<Found, kRing> ring_{};
  std::atomic<std::uint32_t> put_ = 0;
  std::atomic<std::uint32_t> taken_ = 0;

  // The main thread.
  bool reported_ = false;
  std::optional<Unwinder> unwinder_;  // created with the first violation

  mutable PriorityMutex mutex_;
  ViolationPlaces places_;
};

}  // namespace rack
