#include "components/runtime/crash.h"

#include <array>
#include <atomic>
#include <charconv>
#include <csignal>
#include <string_view>

#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include "components/runtime/backtrace.h"
#include "components/runtime/logic/function_names.h"

// Nothing here may allocate, lock or use stdio: the crash may have happened inside of them.
namespace rack {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kReports = false;
#else
constexpr bool kReports = true;
#endif

constexpr int kSignals[] = {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL};
constexpr std::size_t kFrames = 48;
constexpr std::size_t kNameMax = 512;

Unwinder* unwinder = nullptr;      // made before there is anything to report
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

std::string_view name_of(int signal) {
  switch (signal) {
    case SIGSEGV:
      return "SIGSEGV";
    case SIGABRT:
      return "SIGABRT";
    case SIGBUS:
      return "SIGBUS";
    case SIGFPE:
      return "SIGFPE";
    case SIGILL:
      return "SIGILL";
    default:
      return "signal";
  }
}

// "#3 rack::Module::run + 0x1f (libx.so)"
void say_frame(std::size_t index, std::uint64_t address) {
  std::array<char, kNameMax> mangled;
  std::array<char, kNameMax> room;
  const Symbol symbol = find_symbol(unwinder->files(), code_of_frame(index, address), mangled);
  say("  #");
  say_number(index, 10);
  say(" ");
  say(symbol.name.empty() ? std::string_view("?") : readable_name(symbol.name, room));
  say(" + 0x");
  say_number(symbol.offset, 16);
  if (!symbol.file.empty()) {
    say(" (");
    say(symbol.file);
    say(")");
  }
  say("\n");
}

void report(int signal, const siginfo_t& info, const ucontext_t& context) {
  std::array<char, 17> thread{};
  ::prctl(PR_GET_NAME, thread.data());
  say("Crash: ");
  say(name_of(signal));
  // Who sends a signal says no address.
  if (signal != SIGABRT && info.si_code > 0) {
    say(" at 0x");
    say_number(reinterpret_cast<std::uintptr_t>(info.si_addr), 16);
  }
  say(" in thread ");
  say(thread.data());
  say("\n");
  std::array<std::uint64_t, kFrames> room;
  const auto frames = unwinder->frames(context, room);
  for (std::size_t i = 0; i < frames.size(); ++i) say_frame(i, frames[i]);
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

void install_crash_report() {
  if (!kReports || unwinder != nullptr) return;
  static Unwinder made;
  unwinder = &made;
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
