#include "components/runtime/perf_events.h"

#include <atomic>
#include <bit>

#include <linux/perf_event.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "components/runtime/backtrace.h"

namespace rack {
namespace {

constexpr std::uint64_t kSampledRegisters = [] {
  std::uint64_t all = 0;
  for (const RegisterName& name : kRegisterNames) all |= std::uint64_t{1} << name.sampled;
  return all;
}();
constexpr std::size_t kRing = 256 << 10;  // bytes; a hundred samples

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
  // Nobody waits for records.
  wanted.watermark = 1;
  wanted.wakeup_watermark = kRing;
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

}  // namespace

PerfEvents::~PerfEvents() { close(); }

PerfEvents::Depth PerfEvents::open() {
  if (open_events(true)) return Depth::kAllPlaces;
  if (open_events(false)) return Depth::kFaultPlaces;
  return Depth::kNothing;
}

// Switches happen inside the kernel, at which not everybody may look (perf_event_paranoid).
bool PerfEvents::open_events(bool with_kernel) {
  close();
  perf_event_attr faults = attributes(PERF_COUNT_SW_PAGE_FAULTS, with_kernel);
  faults.context_switch = 1;  // and records that say why
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
  void* memory = ::mmap(nullptr, page() + kRing, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE,
                        faults_.get(), 0);
  if (memory == MAP_FAILED) return false;
  memory_ = memory;
  touch_ring();
  return true;
}

// So that reading it is no page fault of the thread that is watched.
void PerfEvents::touch_ring() {
  const volatile std::byte* ring = static_cast<const std::byte*>(memory_);
  for (std::size_t at = 0; at < kRing; at += page()) (void)ring[page() + at];
  at_ = written(memory_);
  give_back(memory_, at_);
}

void PerfEvents::close() {
  if (memory_ != nullptr) ::munmap(memory_, page() + kRing);
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
  const std::span ring(static_cast<const std::byte*>(memory_) + page(), kRing);
  const bool whole = read_record(ring, at_, end, layout_, record);
  if (!whole) at_ = end;
  give_back(memory_, at_);
  return whole;
}

}  // namespace rack
