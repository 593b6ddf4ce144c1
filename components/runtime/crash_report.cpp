// tims-crash-report: prints the back-trace of a component that has crashed. The component starts it
// and does not wait for it (crash.h).
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "components/runtime/backtrace.h"
#include "components/runtime/crash.h"

namespace {

constexpr unsigned kPatience = 30;  // s; symbol files may be on a network

// "  #3 rack::Module::run(int, char**) at module.cpp:42"
std::string line(rack::Unwinder& unwinder, std::size_t index, std::uint64_t address) {
  const std::string source = unwinder.source(address);
  return fmt::format("  #{} {}{}{}\n", index, unwinder.function(address).name,
                     source.empty() ? "" : " at ", source);
}

}  // namespace

int main() {
  rack::CrashRecord record;
  if (std::fread(&record, sizeof record, 1, stdin) != 1) {
    std::fputs("tims-crash-report is only started by a component that crashes\n", stderr);
    return 2;
  }
  ::alarm(kPatience);
  std::vector<std::byte> stack(record.stack_size);
  stack.resize(std::fread(stack.data(), 1, stack.size(), stdin));
  rack::Unwinder unwinder(stdin);
  std::array<std::uint64_t, rack::kFramesMax> room{};
  std::string text = fmt::format("Back-trace of {} ({}):\n", record.thread.data(), record.process);
  std::size_t index = 0;
  for (const std::uint64_t address :
       unwinder.frames({record.registers, stack, record.stack_begin}, room))
    text += line(unwinder, index++, address);
  std::fputs(text.c_str(), stderr);
  return 0;
}
