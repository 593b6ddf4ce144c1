// Back-traces with names: of a thread at the time of a kernel sample (RealTimeWatch), and of a
// thread that has crashed (crash_report.cpp). The input is the registers and the top of the stack.
// libdw (elfutils) unwinds by the tables that the compiler adds to every program, so it also works
// for functions without frame pointers, and it knows names, files and lines. It allocates, so an
// Unwinder must not be used in a signal handler.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <span>
#include <string>
#include <unordered_map>

#include <ucontext.h>

#if defined(__x86_64__) || defined(__aarch64__)
#include <asm/perf_regs.h>
#endif

struct Dwfl;

namespace rack {

// --- A thread's registers in the order of kernel samples: one table per architecture. Without a
// table, back-traces consist of frame pointers only.

struct RegisterName {
  int sampled;        // bit that requests it from the kernel
  int signal;         // index in the context of a signal handler
  std::size_t dwarf;  // DWARF register number; behind those, the program counter where it has none
};

#if defined(__x86_64__)
inline constexpr std::array<RegisterName, 17> kRegisterNames = {{
    {PERF_REG_X86_AX, REG_RAX, 0},
    {PERF_REG_X86_BX, REG_RBX, 3},
    {PERF_REG_X86_CX, REG_RCX, 2},
    {PERF_REG_X86_DX, REG_RDX, 1},
    {PERF_REG_X86_SI, REG_RSI, 4},
    {PERF_REG_X86_DI, REG_RDI, 5},
    {PERF_REG_X86_BP, REG_RBP, 6},
    {PERF_REG_X86_SP, REG_RSP, 7},
    {PERF_REG_X86_IP, REG_RIP, 16},
    {PERF_REG_X86_R8, REG_R8, 8},
    {PERF_REG_X86_R9, REG_R9, 9},
    {PERF_REG_X86_R10, REG_R10, 10},
    {PERF_REG_X86_R11, REG_R11, 11},
    {PERF_REG_X86_R12, REG_R12, 12},
    {PERF_REG_X86_R13, REG_R13, 13},
    {PERF_REG_X86_R14, REG_R14, 14},
    {PERF_REG_X86_R15, REG_R15, 15},
}};
inline constexpr std::size_t kStackPointer = 7;
inline constexpr std::size_t kInstructionPointer = 16;
inline constexpr std::size_t kDwarfRegisters = 17;
inline constexpr std::size_t kRedZone = 128;  // bytes below the stack pointer that are in use
#elif defined(__aarch64__)
// x0 to x30, the stack pointer and the program counter, which is no register of DWARF here.
inline constexpr auto kRegisterNames = [] {
  std::array<RegisterName, PERF_REG_ARM64_MAX> names{};
  for (std::size_t i = 0; i < names.size(); ++i)
    names[i] = {.sampled = static_cast<int>(i), .signal = static_cast<int>(i), .dwarf = i};
  return names;
}();
inline constexpr std::size_t kStackPointer = PERF_REG_ARM64_SP;
inline constexpr std::size_t kInstructionPointer = PERF_REG_ARM64_PC;
inline constexpr std::size_t kDwarfRegisters = 32;
inline constexpr std::size_t kRedZone = 0;
#else
inline constexpr std::array<RegisterName, 0> kRegisterNames{};
inline constexpr std::size_t kStackPointer = 0;
inline constexpr std::size_t kInstructionPointer = 0;
inline constexpr std::size_t kDwarfRegisters = 0;
inline constexpr std::size_t kRedZone = 0;
#endif

using Registers = std::array<std::uint64_t, kRegisterNames.size()>;  // by DWARF's numbers

inline Registers registers_of([[maybe_unused]] const ucontext_t& context) {
  Registers registers{};
#if defined(__x86_64__)
  for (const RegisterName& name : kRegisterNames)
    registers[name.dwarf] = static_cast<std::uint64_t>(context.uc_mcontext.gregs[name.signal]);
#elif defined(__aarch64__)
  const auto& given = context.uc_mcontext;
  std::copy(std::begin(given.regs), std::end(given.regs), registers.begin());
  registers[kStackPointer] = given.sp;
  registers[kInstructionPointer] = given.pc;
#endif
  return registers;
}

// --- Back-traces

struct ThreadState {
  Registers registers{};
  std::span<const std::byte> stack{};  // the known part
  std::uint64_t stack_begin = 0;       // its address
  // Return addresses found by frame pointers; a fallback.
  std::span<const std::uint64_t> frame_pointers{};
};

inline constexpr std::size_t kFramesMax = 48;  // maximum length of a printed back-trace

class Unwinder {
 public:
  Unwinder();                          // for this process
  explicit Unwinder(std::FILE* maps);  // for a process with this /proc/PID/maps
  Unwinder(const Unwinder&) = delete;
  Unwinder& operator=(const Unwinder&) = delete;
  ~Unwinder();

  // Writes the frames to `room`, innermost first: the current address of each function, for callers
  // that of the call.
  std::span<std::uint64_t> frames(const ThreadState& thread, std::span<std::uint64_t> room);

  struct Function {
    std::string name;    // "rack::Module::run(int, char**)", "libc.so.6 + 0x1234"
    bool known = false;  // the name is that of a function
  };
  const Function& function(std::uint64_t address);  // cached
  // "offender.cpp:42"; empty: not known.
  [[nodiscard]] std::string source(std::uint64_t address) const;

 private:
  void attach();
  void look_for(std::uint64_t address);

  Dwfl* dwfl_;
  bool own_;                             // this process: more libraries may be loaded
  const ThreadState* thread_ = nullptr;  // thread that frames() unwinds
  std::unordered_map<std::uint64_t, Function> functions_;
};

}  // namespace rack
