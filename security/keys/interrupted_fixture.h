// For tests: runs some work in a child process and kills it, or lets a system call fail for lack of
// space, at the n-th system call that changes a file; or lets this one and all later ones fail,
// because the file system has become read-only. For n = 0, 1, 2, ... that is every moment at which
// a power failure, a full disk or a broken one can strike.
#pragma once

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <functional>

#include <elf.h>
#include <fcntl.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tims::security {

enum class Interruption : std::uint8_t { kKill, kNoSpace, kReadOnly };

struct Interrupted {
  bool reached = false;    // there were so many calls
  bool succeeded = false;  // the work returned true
};

namespace interrupted {

inline bool changes_files(const __ptrace_syscall_info& call, Interruption how) {
  const auto number = static_cast<long>(call.entry.nr);
  switch (number) {
    case SYS_write:
    case SYS_fsync:
      return true;
    case SYS_openat:
      return (call.entry.args[2] & O_CREAT) != 0;
    case SYS_renameat:
    case SYS_unlinkat:
    case SYS_mkdirat:
      return how != Interruption::kNoSpace;  // these need no space
#ifdef SYS_rename
    case SYS_rename:
    case SYS_unlink:
    case SYS_mkdir:
      return how != Interruption::kNoSpace;
#endif
    default:
      return false;
  }
}

// At the entry of a call: it is not made, and fails.
inline bool let_fail(pid_t child, int error) {
#if defined(__x86_64__)
  user_regs_struct registers{};
  iovec place{&registers, sizeof registers};
  if (::ptrace(PTRACE_GETREGSET, child, NT_PRSTATUS, &place) != 0) return false;
  registers.orig_rax = static_cast<unsigned long long>(-1);
  if (::ptrace(PTRACE_SETREGSET, child, NT_PRSTATUS, &place) != 0) return false;
  ::ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
  int status = 0;
  if (::waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) return false;
  registers.rax = static_cast<unsigned long long>(-error);
  return ::ptrace(PTRACE_SETREGSET, child, NT_PRSTATUS, &place) == 0;
#else
  (void)error;
  return ::kill(child, SIGKILL) == 0;
#endif
}

}  // namespace interrupted

inline Interrupted run_interrupted(const std::function<bool()>& work, Interruption how, int at) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    ::raise(SIGSTOP);
    ::_exit(work() ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ::ptrace(PTRACE_SETOPTIONS, child, nullptr, PTRACE_O_EXITKILL | PTRACE_O_TRACESYSGOOD);
  Interrupted result;
  for (int calls = 0;;) {
    ::ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
    if (::waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) break;
    const bool goes_on = how == Interruption::kReadOnly;
    if ((result.reached && !goes_on) || WSTOPSIG(status) != (SIGTRAP | 0x80)) continue;
    __ptrace_syscall_info call{};
    ::ptrace(PTRACE_GET_SYSCALL_INFO, child, sizeof call, &call);
    if (call.op != PTRACE_SYSCALL_INFO_ENTRY || !interrupted::changes_files(call, how)) continue;
    if (calls++ < at) continue;
    result.reached = true;
    if (how == Interruption::kKill)
      ::kill(child, SIGKILL);
    else if (!interrupted::let_fail(child, goes_on ? EROFS : ENOSPC))
      break;
  }
  result.succeeded = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  return result;
}

}  // namespace tims::security
