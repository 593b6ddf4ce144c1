#include "components/runtime/real_time_watch.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <linux/perf_event.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "components/runtime/backtrace.h"
#include "components/runtime/robot_run.h"
#include "os/environment.h"
#include "rack/thread.h"

namespace rack {

namespace {

constexpr std::uint64_t kSampledRegisters = [] {
  std::uint64_t all = 0;
  for (const RegisterName& name : kRegisterNames) all |= std::uint64_t{1} << name.sampled;
  return all;
}();
constexpr std::size_t kRealTimeWatchRing = 256 << 10;  // bytes; a hundred samples

std::size_t page() { return static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)); }

perf_event_attr attributes(std::uint64_t event, bool with_kernel) {
  perf_event_attr wanted{};
  wanted.size = sizeof wanted;
  wanted.type = PERF_TYPE_SOFTWARE;
  wanted.config = event;
  wanted.sample_period = 1;
  wanted.sample_type = PERF_SAMPLE_IDENTIFIER | PERF_SAMPLE_CALLCHAIN | PERF_SAMPLE_REGS_USER |
                       PERF_SAMPLE_STACK_USER;
  wanted.sample_regs_user = kSampledRegisters;
  wanted.sample_stack_user = kSampledRegisters == 0 ? 0 : Snapshot::kStackMax;
  wanted.exclude_callchain_kernel = 1;
  wanted.exclude_kernel = with_kernel ? 0 : 1;
  // No thread waits for records.
  wanted.watermark = 1;
  wanted.wakeup_watermark = kRealTimeWatchRing;
  return wanted;
}

tims::os::File open_event(perf_event_attr wanted) {
  constexpr pid_t kThisThread = 0;
  constexpr int kAnyCpu = -1;
  constexpr int kNoGroup = -1;
  return tims::os::File(static_cast<int>(::syscall(SYS_perf_event_open, &wanted, kThisThread,
                                                   kAnyCpu, kNoGroup, PERF_FLAG_FD_CLOEXEC)));
}

perf_event_mmap_page& head_page(void* memory) {
  return *static_cast<perf_event_mmap_page*>(memory);
}

std::uint64_t written(void* memory) {
  return std::atomic_ref(head_page(memory).data_head).load(std::memory_order_acquire);
}

void give_back(void* memory, std::uint64_t up_to) {
  std::atomic_ref(head_page(memory).data_tail).store(up_to, std::memory_order_release);
}

constexpr std::string_view kOutermost = "rack::Module::Runtime::watched_loop";

// Only the task writes the counters, so no atomic addition is needed.
void add(std::atomic<std::int64_t>& counter, std::int64_t more) {
  counter.store(counter.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
}

const char* text_of(Violation violation) {
  return violation == Violation::kPageFault ? "a page fault" : "blocked";
}

ThreadState thread_of(const Snapshot& snapshot) {
  ThreadState thread{.frame_pointers = snapshot.frames()};
  if constexpr (!kRegisterNames.empty()) {
    if (snapshot.register_count != kRegisterNames.size()) return thread;
    for (std::size_t i = 0; i < kRegisterNames.size(); ++i)
      thread.registers[kRegisterNames[i].dwarf] = snapshot.registers[i];
    thread.stack = std::span(snapshot.stack).first(snapshot.stack_size);
    thread.stack_begin = thread.registers[kStackPointer];
  }
  return thread;
}

}  // namespace

PerfEvents::~PerfEvents() { close(); }

WatchDepth PerfEvents::open() {
  if (open_events(true)) return WatchDepth::kAllPlaces;
  if (open_events(false)) return WatchDepth::kFaultPlaces;
  return WatchDepth::kCounts;
}

// Context switches happen inside the kernel, whose events may be restricted (perf_event_paranoid).
bool PerfEvents::open_events(bool with_kernel) {
  close();
  perf_event_attr faults = attributes(PERF_COUNT_SW_PAGE_FAULTS, with_kernel);
  faults.context_switch = 1;  // and records with the kind of the switch
  faults_ = open_event(faults);
  if (faults_ && with_kernel)
    switches_ = open_event(attributes(PERF_COUNT_SW_CONTEXT_SWITCHES, true));
  if (!faults_ || (with_kernel && !switches_)) {
    error_ = tims::os::system_error("perf_event_open");
    return false;
  }
  layout_ = {.registers = static_cast<std::uint32_t>(std::popcount(kSampledRegisters))};
  const bool good =
      ::ioctl(faults_.get(), PERF_EVENT_IOC_ID, &layout_.fault_id) == 0 && map_ring() &&
      (!switches_ || (::ioctl(switches_.get(), PERF_EVENT_IOC_ID, &layout_.switch_id) == 0 &&
                      ::ioctl(switches_.get(), PERF_EVENT_IOC_SET_OUTPUT, faults_.get()) == 0));
  if (!good) error_ = tims::os::system_error("ring of perf events");
  return good;
}

bool PerfEvents::map_ring() {
  void* memory = ::mmap(nullptr, page() + kRealTimeWatchRing, PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_POPULATE, faults_.get(), 0);
  if (memory == MAP_FAILED) return false;
  memory_ = memory;
  prefault_ring();
  return true;
}

// So that reading the ring is not a page fault of the watched thread.
void PerfEvents::prefault_ring() {
  const volatile std::byte* ring = static_cast<const std::byte*>(memory_);
  for (std::size_t at = 0; at < kRealTimeWatchRing; at += page()) (void)ring[page() + at];
  at_ = written(memory_);
  give_back(memory_, at_);
}

void PerfEvents::close() {
  if (memory_ != nullptr) ::munmap(memory_, page() + kRealTimeWatchRing);
  memory_ = nullptr;
  switches_.reset();
  faults_.reset();
}

void PerfEvents::skip() {
  const std::uint64_t end = written(memory_);
  if (end == at_) return;
  at_ = end;
  give_back(memory_, at_);
}

bool PerfEvents::next(PerfRecord& record) {
  const std::uint64_t end = written(memory_);
  if (end == at_) return false;
  const std::span ring(static_cast<const std::byte*>(memory_) + page(), kRealTimeWatchRing);
  const bool whole = read_record(ring, at_, end, layout_, record);
  if (!whole) at_ = end;
  give_back(memory_, at_);
  return whole;
}

bool is_watched(int priority) {
  const std::string setting = tims::os::environment("RACK_WATCH");
  if (!setting.empty()) return setting[0] != '0';
  return priority >= kFirstRealTime;
}

// --- the task

void RealTimeWatch::start(TextLog& log) {
  const WatchDepth depth = events_.open();
  if (depth == WatchDepth::kCounts)
    log.info("Real-time violations are counted without locations: {}", events_.error().detail());
  if (depth == WatchDepth::kFaultPlaces)
    log.info("Real-time violations have no locations of context switches (needs CAP_PERFMON)");
  before_ = usage();
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

// Events before the section do not count.
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
      hand_over(Violation::kPageFault, &record.snapshot);
      break;
    case PerfRecord::Kind::kSwitch:
      switch_ = record.snapshot;
      switch_seen_ = true;
      break;
    case PerfRecord::Kind::kSwitchedOut:
      add(record.preempted ? preempted_ : blocked_, 1);
      if (!record.preempted) hand_over(Violation::kBlocked, switch_seen_ ? &switch_ : nullptr);
      switch_seen_ = false;
      break;
  }
}

// When the ring is full, only the counts are kept.
void RealTimeWatch::hand_over(Violation violation, const Snapshot* snapshot) {
  const std::uint32_t put = put_.load(std::memory_order_relaxed);
  if (snapshot == nullptr || put - taken_.load(std::memory_order_acquire) == kRing) return;
  ring_[put % kRing] = {violation, *snapshot};
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
    const Violation violation = found.violation;
    const std::string place = where(found);
    taken_.store(++taken, std::memory_order_release);
    bool is_new = false;
    {
      const std::lock_guard lock(mutex_);
      is_new = places_.add(violation, place);
    }
    if (is_new) log.detail("Not in real time: {} in {}", text_of(violation), place);
    if (!std::exchange(reported_, true))
      log.write(first_of_robot("real-time") ? gdos::Level::kWarning : gdos::Level::kInfo,
                "Not always in real time: `timsctl component show` lists the locations");
  }
}

std::string RealTimeWatch::where(const Found& found) {
  std::array<std::uint64_t, kFramesMax> room{};
  if (!unwinder_) unwinder_.emplace();
  std::vector<std::string> functions;
  for (const std::uint64_t address : unwinder_->frames(thread_of(found.snapshot), room)) {
    const Unwinder::Function& function = unwinder_->function(address);
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
  for (const ViolationPlaces::Place& place : places_.worst(decltype(data.places)::kMax)) {
    RuntimePlace& place_data = data.places.emplace_back();
    place_data.kind = place.violation == Violation::kPageFault ? RuntimePlace::kPageFault
                                                               : RuntimePlace::kBlocked;
    place_data.count = static_cast<i64>(place.count);
    (void)place_data.where.assign(place.text);
  }
}

}  // namespace rack
