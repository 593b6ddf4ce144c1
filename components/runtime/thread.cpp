#include "rack/thread.h"

#include <array>
#include <cerrno>
#include <system_error>

#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include "components/runtime/crash.h"

namespace rack {
namespace {

constexpr std::size_t kStack = 2 << 20;
constexpr std::size_t kTouched =
    256 << 10;  // bytes of the stack touched before the thread's work begins

tims::Error refused(const std::string& what, int code) {
  std::string text = what + ": " + std::generic_category().message(code);
  if (code == EPERM) text += " (needs CAP_SYS_NICE, or LimitRTPRIO= of the service)";
  return {tims::Errc::kSystem, std::move(text)};
}

void prefault_stack() {
  std::array<volatile char, kTouched> stack;
  for (std::size_t i = 0; i < stack.size(); i += 1024) stack[i] = 0;
}

int existing_cpu(int cpu) { return cpu < ::sysconf(_SC_NPROCESSORS_ONLN) ? cpu : 0; }

void set_real_time(pthread_attr_t& attributes, const ThreadSettings& settings) {
  const sched_param priority{.sched_priority = settings.priority};
  ::pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  ::pthread_attr_setschedpolicy(&attributes, SCHED_FIFO);
  ::pthread_attr_setschedparam(&attributes, &priority);
  if (settings.cpu == kAnyCpu) return;
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(static_cast<std::size_t>(existing_cpu(settings.cpu)), &cpus);
  ::pthread_attr_setaffinity_np(&attributes, sizeof cpus, &cpus);
}

bool is_real_time() {
  const int policy = ::sched_getscheduler(0);
  return policy == SCHED_FIFO || policy == SCHED_RR;
}

// A thread inherits the policy and the CPU of the one that starts it. This one gets the CPUs of the
// main thread.
void set_ordinary(pthread_attr_t& attributes) {
  const sched_param priority{};
  ::pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  ::pthread_attr_setschedpolicy(&attributes, SCHED_OTHER);
  ::pthread_attr_setschedparam(&attributes, &priority);
  cpu_set_t cpus;
  if (::sched_getaffinity(::getpid(), sizeof cpus, &cpus) == 0)
    ::pthread_attr_setaffinity_np(&attributes, sizeof cpus, &cpus);
}

}  // namespace

tims::Result<void> Thread::start(const ThreadSettings& settings, std::function<void()> body) {
  body_ = std::move(body);
  pthread_attr_t attributes;
  ::pthread_attr_init(&attributes);
  ::pthread_attr_setstacksize(&attributes, kStack);
  if (settings.priority >= kFirstRealTime)
    set_real_time(attributes, settings);
  else if (is_real_time())
    set_ordinary(attributes);
  const int code = ::pthread_create(&id_, &attributes, &Thread::run, this);
  ::pthread_attr_destroy(&attributes);
  if (code != 0)
    return refused("starting a thread with priority " + std::to_string(settings.priority), code);
  running_ = true;
  ::pthread_setname_np(id_, settings.name.substr(0, 15).c_str());
  return {};
}

void* Thread::run(void* self) {
  const CrashStack crash_stack;
  prefault_stack();
  static_cast<Thread*>(self)->body_();
  return nullptr;
}

void Thread::join() {
  if (!running_) return;
  ::pthread_join(id_, nullptr);
  running_ = false;
}

tims::Result<void> lock_memory() {
  // Current memory is loaded now. Later mappings are mostly mailboxes of others, large and never
  // touched completely: ON_FAULT locks only the touched pages.
  if (::mlockall(MCL_CURRENT) != 0 || ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0)
    return refused("locking memory", errno);
  return {};
}

}  // namespace rack
