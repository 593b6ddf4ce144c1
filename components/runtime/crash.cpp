#include "components/runtime/crash.h"

#include <array>
#include <atomic>
#include <charconv>
#include <csignal>
#include <cstring>
#include <string>
#include <string_view>

#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

// Nothing here may allocate, lock or use stdio: the crash may have happened inside of them.
namespace rack {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kReports = false;
#else
constexpr bool kReports = true;
#endif

constexpr int kSignals[] = {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL};
constexpr int kLast = 19;

char* reporter = nullptr;          // its path, from before there is anything to report
std::atomic<pid_t> reporting = 0;  // the thread that does

void say(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
    if (written <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void say_number(std::uint64_t number, int base) {
  std::array<char, 24> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number, base).ptr;
  say({text.data(), static_cast<std::size_t>(end - text.data())});
}

void say_signal(int signal, const siginfo_t& info, const char* thread) {
  say("Crash: SIG");
  say(::sigabbrev_np(signal));
  // Who sends a signal says no address.
  if (signal != SIGABRT && info.si_code > 0) {
    say(" at 0x");
    say_number(reinterpret_cast<std::uintptr_t>(info.si_addr), 16);
  }
  say(" in thread ");
  say(thread);
  say("\n");
}

// For addr2line(1): "#3 /usr/lib/librack.so.0.1 + 0x12ab". Asks the dynamic linker, but for what
// takes no lock of it, which may be held.
void say_addresses(std::uint64_t crashed_at) {
  std::array<void*, kFramesMax> frames{};
  const auto count = static_cast<std::size_t>(::backtrace(frames.data(), kFramesMax));
  bool is_crashed = false;  // before come the handler's own
  for (std::size_t i = 0; i < count; ++i) {
    const auto address = reinterpret_cast<std::uintptr_t>(frames[i]);
    is_crashed = is_crashed || address == crashed_at || crashed_at == 0;
    if (!is_crashed) continue;
    dl_find_object file{};
    const bool known = ::_dl_find_object(frames[i], &file) == 0;
    const char* path = known ? file.dlfo_link_map->l_name : "?";
    say("  # ");
    say(*path == '\0' ? "(program)" : path);
    say(" + 0x");
    say_number(address - (known ? file.dlfo_link_map->l_addr : 0), 16);
    say("\n");
  }
}

void copy_maps(int to) {
  const int maps = ::open("/proc/self/maps", O_RDONLY | O_CLOEXEC);
  std::array<char, 4096> text;
  for (ssize_t size = 0; (size = ::read(maps, text.data(), text.size())) > 0;)
    if (::write(to, text.data(), static_cast<std::size_t>(size)) != size) break;
}

// In memory, which has room at once however slowly it is read. -1: it cannot be.
int write_record(CrashRecord& record) {
  const int file = ::memfd_create("crash", MFD_CLOEXEC);
  ::lseek(file, sizeof record, SEEK_SET);
  // As much as is there: what is no memory is not read.
  const ssize_t stack = ::syscall(SYS_write, file, record.stack_begin, CrashRecord::kStackMax);
  record.stack_size = stack > 0 ? static_cast<std::uint64_t>(stack) : 0;
  copy_maps(file);
  const bool good = ::pwrite(file, &record, sizeof record, 0) == sizeof record;
  return good && ::lseek(file, 0, SEEK_SET) == 0 ? file : -1;
}

// With time that nobody else wants, however urgent the thread that has crashed. Returns when it
// cannot start.
void become_reporter(int record) {
  const sched_param ordinary{};
  ::sched_setscheduler(0, SCHED_BATCH, &ordinary);
  ::setpriority(PRIO_PROCESS, 0, kLast);
  if (record < 0 || ::dup2(record, STDIN_FILENO) < 0) return;
  char* const arguments[] = {reporter, nullptr};
  ::execve(reporter, arguments, environ);
}

void report(int signal, const siginfo_t& info, const ucontext_t& context) {
  CrashRecord record{.process = ::getpid(), .registers = registers_of(context)};
  ::prctl(PR_GET_NAME, record.thread.data());
  say_signal(signal, info, record.thread.data());
  std::uint64_t crashed_at = 0;
  if constexpr (!kRegisterNames.empty()) {
    crashed_at = record.registers[kInstructionPointer];
    record.stack_begin = record.registers[kStackPointer] - kRedZone;
  }
  const int file = kRegisterNames.empty() ? -1 : write_record(record);
  const pid_t child = ::_Fork();  // fork() would take locks
  if (child > 0) return;
  if (child == 0) become_reporter(file);
  say("  ");
  say(reporter);
  say(" does not start; addresses, for addr2line:\n");
  say_addresses(crashed_at);
  if (child == 0) ::_exit(1);
}

void on_crash(int signal, siginfo_t* info, void* context) {
  const auto self = static_cast<pid_t>(::syscall(SYS_gettid));
  pid_t nobody = 0;
  if (reporting.compare_exchange_strong(nobody, self)) {
    report(signal, *info, *static_cast<const ucontext_t*>(context));
  } else if (nobody != self) {
    // Another thread has crashed before, and ends all of us when it has said so.
    for (;;) ::pause();
  }
  // Delivered when this returns: the end, and the core file, are those of the crash.
  std::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

void install_crash_report(const std::string& reporter_program) {
  if (!kReports || reporter != nullptr) return;
  static std::string path = reporter_program;
  reporter = path.data();
  std::array<void*, 1> frame{};
  ::backtrace(frame.data(), 1);  // loads what it needs
  struct sigaction action {};
  action.sa_sigaction = on_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  ::sigemptyset(&action.sa_mask);
  for (const int signal : kSignals) ::sigaction(signal, &action, nullptr);
}

CrashStack::CrashStack() {
  if (!kReports) return;
  memory_ = std::make_unique<std::byte[]>(kSize);
  stack_t stack{};
  stack.ss_sp = memory_.get();
  stack.ss_size = kSize;
  ::sigaltstack(&stack, nullptr);
}

CrashStack::~CrashStack() {
  if (memory_ == nullptr) return;
  stack_t none{};
  none.ss_flags = SS_DISABLE;
  ::sigaltstack(&none, nullptr);
}

}  // namespace rack
