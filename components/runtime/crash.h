// Prints a back-trace to standard error when a component crashes, which then ends as it would
// without this: same signal, same core file.
//
// The signal handler only collects registers, the top of the stack, and the loaded files. Then it
// starts another program, tims-crash-report, which may allocate as libdw does, and lets this
// process end: those that must notice the crash (the router, the supervisor, consumers of its data)
// do not wait for the names.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>

#include <sys/types.h>

#include "components/runtime/backtrace.h"
#include "os/environment.h"

namespace rack {

// Call once at the start of the program. With sanitizers it does nothing: they have their own
// reports.
void install_crash_report(
    const std::string& reporter_program = tims::os::find_program("tims-crash-report"));

// An alternative stack for the handler, as the normal one may be exhausted. One per thread, created
// in the thread.
class CrashStack {
 public:
  CrashStack();
  CrashStack(const CrashStack&) = delete;
  CrashStack& operator=(const CrashStack&) = delete;
  ~CrashStack();

 private:
  static constexpr std::size_t kSize = 128 << 10;
  std::unique_ptr<std::byte[]> memory_;
};

// The input of tims-crash-report; followed by stack_size bytes of the stack and the contents of
// /proc/PID/maps.
struct CrashRecord {
  static constexpr std::size_t kStackMax = 256 << 10;

  pid_t process = 0;
  std::array<char, 16> thread{};  // its name
  Registers registers{};
  std::uint64_t stack_begin = 0;
  std::uint64_t stack_size = 0;
};

}  // namespace rack
