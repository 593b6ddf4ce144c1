// Names of a thread's registers, in the order in which the kernel samples them: one table an
// architecture. Where there is none, back-traces consist of frame pointers alone.
#pragma once

#include <array>
#include <cstdint>

#include <libunwind.h>
#include <ucontext.h>

#if defined(__x86_64__)
#include <asm/perf_regs.h>
#endif

namespace rack {

struct RegisterName {
  int sampled;   // the bit that asks the kernel for it
  int signal;    // where it lies in what a signal handler is given
  int unwinder;  // what the unwinder calls it
};

#if defined(__x86_64__)
inline constexpr std::array<RegisterName, 17> kRegisterNames = {{
    {PERF_REG_X86_AX, REG_RAX, UNW_X86_64_RAX},
    {PERF_REG_X86_BX, REG_RBX, UNW_X86_64_RBX},
    {PERF_REG_X86_CX, REG_RCX, UNW_X86_64_RCX},
    {PERF_REG_X86_DX, REG_RDX, UNW_X86_64_RDX},
    {PERF_REG_X86_SI, REG_RSI, UNW_X86_64_RSI},
    {PERF_REG_X86_DI, REG_RDI, UNW_X86_64_RDI},
    {PERF_REG_X86_BP, REG_RBP, UNW_X86_64_RBP},
    {PERF_REG_X86_SP, REG_RSP, UNW_X86_64_RSP},
    {PERF_REG_X86_IP, REG_RIP, UNW_X86_64_RIP},
    {PERF_REG_X86_R8, REG_R8, UNW_X86_64_R8},
    {PERF_REG_X86_R9, REG_R9, UNW_X86_64_R9},
    {PERF_REG_X86_R10, REG_R10, UNW_X86_64_R10},
    {PERF_REG_X86_R11, REG_R11, UNW_X86_64_R11},
    {PERF_REG_X86_R12, REG_R12, UNW_X86_64_R12},
    {PERF_REG_X86_R13, REG_R13, UNW_X86_64_R13},
    {PERF_REG_X86_R14, REG_R14, UNW_X86_64_R14},
    {PERF_REG_X86_R15, REG_R15, UNW_X86_64_R15},
}};
#else
inline constexpr std::array<RegisterName, 0> kRegisterNames{};
#endif

inline constexpr std::uint64_t kSampledRegisters = [] {
  std::uint64_t all = 0;
  for (const RegisterName name : kRegisterNames) all |= std::uint64_t{1} << name.sampled;
  return all;
}();

}  // namespace rack
