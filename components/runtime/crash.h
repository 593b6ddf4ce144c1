// When a component crashes: who called whom, on standard error, while it ends as it would have.
//
// The signal's handler only writes down what is needed for that: registers, the top of the stack,
// and which files are loaded where. Then it starts another program, tims-crash-report, which may
// allocate as libdw does, and lets this one die: whoever must notice that it is gone (the router,
// its supervisor, those that lived on its data) waits for no names.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>

#include <sys/types.h>

#include "components/runtime/backtrace.h"
#include "os/environment.h"

namespace rack {

// Of the whole program, once, at its beginning. Sanitizers have their own reports: then nothing.
void install_crash_report(
    const std::string& reporter_program = tims::os::find_program("tims-crash-report"));

// A stack for the handler, as the crashed one may be full. One a thread, in the thread.
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

// What tims-crash-report finds on its standard input; then come stack_size bytes of the stack, and
// what was in /proc/PID/maps.
struct CrashRecord {
  static constexpr std::size_t kStackMax = 256 << 10;

  pid_t process = 0;
  std::array<char, 16> thread{};  // its name
  Registers registers{};
  std::uint64_t stack_begin = 0;
  std::uint64_t stack_size = 0;
};

}  // namespace rack
