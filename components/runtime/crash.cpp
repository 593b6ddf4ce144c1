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

char* reporter = nullptr;          // path of the reporter, set before any crash
std::atomic<pid_t> reporting = 0;  // id of the thread that reports

void write_text(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
    if (written <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void write_number(std::uint64_t number, int base) {
  std::array<char, 24> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number, base).ptr;
  write_text({text.data(), static_cast<std::size_t>(end - text.data())});
}

void write_signal(int signal, const siginfo_t& info, const char* thread) {
  write_text("Crash: SIG");
  write_text(::sigabbrev_np(signal));
  // A signal sent by a process has no address.
  if (signal != SIGABRT && info.si_code > 0) {
    write_text(" at 0x");
    write_number(reinterpret_cast<std::uintptr_t>(info.si_addr), 16);
  }
  write_text(" in thread ");
  write_text(thread);
  write_text("\n");
}

// Writes addresses for addr2line(1): "#3 /usr/lib/librack.so.0.1 + 0x12ab". Uses only those
// functions of the dynamic linker that take no lock, which may be held.
void write_addresses(std::uint64_t crashed_at) {
  std::array<void*, kFramesMax> frames{};
  const auto count = static_cast<std::size_t>(::backtrace(frames.data(), kFramesMax));
  bool is_crashed = false;  // the first frames are those of the handler
  for (std::size_t i = 0; i < count; ++i) {
    const auto address = reinterpret_cast<std::uintptr_t>(frames[i]);
    is_crashed = is_crashed || address == crashed_at || crashed_at == 0;
    if (!is_crashed) continue;
    dl_find_object file{};
    const bool known = ::_dl_find_object(frames[i], &file) == 0;
    const char* path = known ? file.dlfo_link_map->l_name : "?";
    write_text("  # ");
    write_text(*path == '\0' ? "(program)" : path);
    write_text(" + 0x");
    write_number(address - (known ? file.dlfo_link_map->l_addr : 0), 16);
    write_text("\n");
  }
}

void copy_maps(int to) {
  const int maps = ::open("/proc/self/maps", O_RDONLY | O_CLOEXEC);
  std::array<char, 4096> text;
  for (ssize_t size = 0; (size = ::read(maps, text.data(), text.size())) > 0;)
    if (::write(to, text.data(), static_cast<std::size_t>(size)) != size) break;
}

// Into a memory file: a pipe would block while the reader is slow. -1: failed.
int write_record(CrashRecord& record) {
  const int file = ::memfd_create("crash", MFD_CLOEXEC);
  ::lseek(file, sizeof record, SEEK_SET);
  // The kernel writes only the mapped part of the stack.
  const ssize_t stack = ::syscall(SYS_write, file, record.stack_begin, CrashRecord::kStackMax);
  record.stack_size = stack > 0 ? static_cast<std::uint64_t>(stack) : 0;
  copy_maps(file);
  const bool good = ::pwrite(file, &record, sizeof record, 0) == sizeof record;
  return good && ::lseek(file, 0, SEEK_SET) == 0 ? file : -1;
}

// Runs the reporter with idle priority, whatever the priority of the crashed thread. Returns only
// if it cannot be started.
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
  write_signal(signal, info, record.thread.data());
  std::uint64_t crashed_at = 0;
  if constexpr (!kRegisterNames.empty()) {
    crashed_at = record.registers[kInstructionPointer];
    record.stack_begin = record.registers[kStackPointer] - kRedZone;
  }
  const int file = kRegisterNames.empty() ? -1 : write_record(record);
  const pid_t child = ::_Fork();  // fork() would take locks
  if (child > 0) return;
  if (child == 0) become_reporter(file);
  write_text("  ");
  write_text(reporter);
  write_text(" cannot be started; addresses for addr2line:\n");
  write_addresses(crashed_at);
  if (child == 0) ::_exit(1);
}

void on_crash(int signal, siginfo_t* info, void* context) {
  const auto self = static_cast<pid_t>(::syscall(SYS_gettid));
  pid_t nobody = 0;
  if (reporting.compare_exchange_strong(nobody, self)) {
    report(signal, *info, *static_cast<const ucontext_t*>(context));
  } else if (nobody != self) {
    // Another thread has crashed before and ends the process after its report.
    for (;;) ::pause();
  }
  // Delivered again on return: exit status and core file are those of the crash.
  std::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

void install_crash_report(const std::string& reporter_program) {
  if (!kReports || reporter != nullptr) return;
  static std::string path = reporter_program;
  reporter = path.data();
  std::array<void*, 1> frame{};
  ::backtrace(frame.data(), 1);  // loads the libraries it needs
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
