#include "components/runtime/real_time_watch.h"

#include <algorithm>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <sys/resource.h>

#include "components/runtime/thread.h"
#include "os/environment.h"

namespace rack {
namespace {

constexpr std::string_view kOutermost = "rack::Module::Life::watched_loop";
constexpr std::size_t kFrames = 48;

// Only the task writes them; an ordinary addition will do.
void add(std::atomic<std::int64_t>& counter, std::int64_t more) {
  counter.store(counter.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
}

const char* words(Offence offence) {
  return offence == Offence::kPageFault ? "a page fault" : "blocked";
}

ThreadState thread_of(const Snapshot& snapshot) {
  ThreadState thread;
  if (snapshot.register_count != kRegisterNames.size()) return thread;
  for (std::size_t i = 0; i < kRegisterNames.size(); ++i)
    thread.registers[kRegisterNames[i].dwarf] = snapshot.registers[i];
  thread.stack = std::span(snapshot.stack).first(snapshot.stack_size);
  thread.stack_begin = thread.registers[kStackPointer];
  return thread;
}

}  // namespace

bool is_watched(int priority) {
  const std::string wish = tims::os::environment("RACK_WATCH");
  if (!wish.empty()) return wish[0] != '0';
  return priority >= kFirstRealTime;
}

// --- the task

void RealTimeWatch::start(TextLog& log) {
  WatchDepth depth = WatchDepth::kCounts;
  switch (events_.open()) {
    case PerfEvents::Depth::kNothing:
      log.info("Real time is watched without places: %s", events_.error().detail());
      before_ = usage();
      break;
    case PerfEvents::Depth::kFaultPlaces:
      log.info("Real time is watched without places of switches (CAP_PERFMON would show them)");
      depth = WatchDepth::kFaultPlaces;
      break;
    case PerfEvents::Depth::kAllPlaces:
      depth = WatchDepth::kAllPlaces;
      break;
  }
  depth_.store(depth, std::memory_order_relaxed);
  tims::set_wait_observer(this);
}

void RealTimeWatch::stop() {
  if (tims::wait_observer() == this) tims::set_wait_observer(nullptr);
}

void RealTimeWatch::enter() {
  if (!on()) return;
  add(loops_, 1);
  inside_ = true;
  open_section();
}

void RealTimeWatch::leave() {
  if (!inside_) return;
  close_section();
  inside_ = false;
}

void RealTimeWatch::begins() {
  if (inside_) close_section();
}

void RealTimeWatch::ends() {
  if (inside_) open_section();
}

// Whatever happened until now is nobody's fault.
void RealTimeWatch::open_section() {
  if (depth() == WatchDepth::kCounts) {
    before_ = usage();
  } else {
    events_.skip();
  }
}

void RealTimeWatch::close_section() {
  if (depth() == WatchDepth::kCounts) return count_usage();
  while (events_.next(record_)) note(record_);
}

void RealTimeWatch::note(const PerfRecord& record) {
  switch (record.kind) {
    case PerfRecord::Kind::kOther:
      break;
    case PerfRecord::Kind::kLost:
      add(lost_, static_cast<std::int64_t>(record.lost));
      break;
    case PerfRecord::Kind::kPageFault:
      add(page_faults_, 1);
      hand_over(Offence::kPageFault, &record.snapshot);
      break;
    case PerfRecord::Kind::kSwitch:
      switch_ = record.snapshot;
      switch_seen_ = true;
      break;
    case PerfRecord::Kind::kSwitchedOut:
      add(record.preempted ? preempted_ : blocked_, 1);
      if (!record.preempted) hand_over(Offence::kBlocked, switch_seen_ ? &switch_ : nullptr);
      switch_seen_ = false;
      break;
  }
}

// When the main thread has no time for more, counts must do.
void RealTimeWatch::hand_over(Offence offence, const Snapshot* snapshot) {
  const std::uint32_t put = put_.load(std::memory_order_relaxed);
  if (snapshot == nullptr || put - taken_.load(std::memory_order_acquire) == kRing) return;
  ring_[put % kRing] = {offence, *snapshot};
  put_.store(put + 1, std::memory_order_release);
}

RealTimeWatch::Usage RealTimeWatch::usage() {
  rusage now{};
  ::getrusage(RUSAGE_THREAD, &now);
  return {now.ru_nvcsw, now.ru_nivcsw, now.ru_minflt + now.ru_majflt};
}

void RealTimeWatch::count_usage() {
  const Usage now = usage();
  add(blocked_, now.blocked - before_.blocked);
  add(preempted_, now.preempted - before_.preempted);
  add(page_faults_, now.page_faults - before_.page_faults);
}

// --- the main thread

void RealTimeWatch::report(TextLog& log) {
  std::uint32_t taken = taken_.load(std::memory_order_relaxed);
  while (taken != put_.load(std::memory_order_acquire)) {
    const Found& found = ring_[taken % kRing];
    const Offence offence = found.offence;
    const std::string place = where(found);
    taken_.store(++taken, std::memory_order_release);
    bool is_new = false;
    {
      const std::lock_guard lock(mutex_);
      is_new = places_.add(offence, place);
    }
    if (is_new) log.detail("Not in real time: %s in %s", words(offence), place);
    if (!std::exchange(said_, true))
      log.warning("Not always in real time: `timsctl component show` tells where");
  }
}

std::string RealTimeWatch::where(const Found& found) {
  std::array<std::uint64_t, kFrames> room{};
  std::span<const std::uint64_t> frames = unwinder_.frames(thread_of(found.snapshot), room);
  if (frames.size() < 2) frames = found.snapshot.frames();
  std::vector<std::string> functions;
  for (const std::uint64_t address : frames) {
    const Unwinder::Function& function = unwinder_.function(address);
    if (functions.empty() || function.known) functions.push_back(function.name);
  }
  return place_text(functions, kOutermost, RuntimePlace::kWhereMax);
}

// --- any thread

void RealTimeWatch::describe(RuntimeData& data) const {
  data.watch = static_cast<i32>(depth());
  data.loops = loops_.load(std::memory_order_relaxed);
  data.blocked = blocked_.load(std::memory_order_relaxed);
  data.preempted = preempted_.load(std::memory_order_relaxed);
  data.pageFaults = page_faults_.load(std::memory_order_relaxed);
  data.lost = lost_.load(std::memory_order_relaxed);
  const std::lock_guard lock(mutex_);
  for (const OffencePlaces::Place& place : places_.worst(decltype(data.places)::kMax)) {
    RuntimePlace& told = data.places.emplace_back();
    told.kind =
        place.offence == Offence::kPageFault ? RuntimePlace::kPageFault : RuntimePlace::kBlocked;
    told.count = static_cast<i64>(place.count);
    (void)told.where.assign(place.text);
  }
}

}  // namespace rack
