// When a component crashes: who called whom, on standard error, before it ends as it would have.
#pragma once

#include <cstddef>
#include <memory>

namespace rack {

// Of the whole program, once, at its beginning. Sanitizers have their own reports: then nothing.
void install_crash_report();

// A stack for the report, as the crashed one may be full. One a thread, in the thread.
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

}  // namespace rack
