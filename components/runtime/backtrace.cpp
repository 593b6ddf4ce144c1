#include "components/runtime/backtrace.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>

#include <cxxabi.h>
#include <elfutils/libdwfl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace rack {

namespace {

constexpr pid_t kThread = 1;  // thread id for libdw; there is only one thread

// Where files with debug information are searched: the default of libdw, and lib/debug/ of the
// installation that this program belongs to, which is below its bin/ or libexec/tims/.
std::string debug_folders() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path own = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  std::string folders = ":.debug:/usr/lib/debug";
  for (const char* prefix : {"..", "../.."})
    folders += ":" + (own / prefix / "lib/debug").lexically_normal().string();
  return folders;
}

// Only files of this host: no requests to a debuginfo server.
const Dwfl_Callbacks& files() {
  static std::string folders = debug_folders();
  static char* path = folders.data();
  static const Dwfl_Callbacks callbacks = {.find_elf = dwfl_linux_proc_find_elf,
                                           .find_debuginfo = dwfl_build_id_find_debuginfo,
                                           .section_address = nullptr,
                                           .debuginfo_path = &path};
  return callbacks;
}

const ThreadState& thread_of(void* argument) {
  return **static_cast<const ThreadState**>(argument);
}

pid_t next_thread(Dwfl*, void* argument, void** thread) {
  if (*thread != nullptr) return 0;
  *thread = argument;
  return kThread;
}

bool read_stack(Dwfl*, Dwarf_Addr address, Dwarf_Word* value, void* argument) {
  const ThreadState& thread = thread_of(argument);
  const std::uint64_t offset = address - thread.stack_begin;
  if (offset >= thread.stack.size() || sizeof *value > thread.stack.size() - offset) return false;
  std::memcpy(value, &thread.stack[offset], sizeof *value);
  return true;
}

bool set_registers([[maybe_unused]] Dwfl_Thread* thread, [[maybe_unused]] void* argument) {
  if constexpr (kRegisterNames.empty()) {
    return false;
  } else {
    const Registers& registers = thread_of(argument).registers;
    if constexpr (kInstructionPointer >= kDwarfRegisters)
      dwfl_thread_state_register_pc(thread, registers[kInstructionPointer]);
    return dwfl_thread_state_registers(thread, 0, kDwarfRegisters, registers.data());
  }
}

constexpr Dwfl_Thread_Callbacks kThreads = {.next_thread = next_thread,
                                            .get_thread = nullptr,
                                            .memory_read = read_stack,
                                            .set_initial_registers = set_registers,
                                            .detach = nullptr,
                                            .thread_detach = nullptr};

struct Frames {
  std::span<std::uint64_t> room;
  std::size_t count = 0;
};

// A return address is behind the call, and may belong to the next function.
int add_frame(Dwfl_Frame* frame, void* argument) {
  Frames& frames = *static_cast<Frames*>(argument);
  Dwarf_Addr address = 0;
  bool is_no_call = false;
  if (frames.count == frames.room.size() || !dwfl_frame_pc(frame, &address, &is_no_call))
    return DWARF_CB_ABORT;
  frames.room[frames.count++] = is_no_call ? address : address - 1;
  return DWARF_CB_OK;
}

std::string_view base_name(std::string_view path) { return path.substr(path.rfind('/') + 1); }

std::string demangled(const char* name) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> text(
      abi::__cxa_demangle(name, nullptr, nullptr, &status), &std::free);
  return status == 0 ? text.get() : name;
}

}  // namespace

Unwinder::Unwinder() : dwfl_(dwfl_begin(&files())), own_(true) {
  dwfl_linux_proc_report(dwfl_, ::getpid());
  attach();
}

Unwinder::Unwinder(std::FILE* maps) : dwfl_(dwfl_begin(&files())), own_(false) {
  dwfl_linux_proc_maps_report(dwfl_, maps);
  attach();
}

void Unwinder::attach() {
  dwfl_report_end(dwfl_, nullptr, nullptr);
  dwfl_attach_state(dwfl_, nullptr, kThread, &kThreads, &thread_);
}

Unwinder::~Unwinder() { dwfl_end(dwfl_); }

void Unwinder::look_for(std::uint64_t address) {
  if (!own_ || dwfl_addrmodule(dwfl_, address) != nullptr) return;
  dwfl_report_begin(dwfl_);
  dwfl_linux_proc_report(dwfl_, ::getpid());
  dwfl_report_end(dwfl_, nullptr, nullptr);
}

std::span<std::uint64_t> Unwinder::frames(const ThreadState& thread,
                                          std::span<std::uint64_t> room) {
  Frames frames{.room = room};
  if constexpr (!kRegisterNames.empty()) {
    look_for(thread.registers[kInstructionPointer]);
    thread_ = &thread;
    dwfl_getthread_frames(dwfl_, kThread, add_frame, &frames);  // as far as possible
  }
  if (frames.count > 1 || thread.frame_pointers.empty()) return room.first(frames.count);
  const std::size_t size = std::min(thread.frame_pointers.size(), room.size());
  for (std::size_t i = 0; i < size; ++i) room[i] = thread.frame_pointers[i] - (i == 0 ? 0 : 1);
  return room.first(size);
}

const Unwinder::Function& Unwinder::function(std::uint64_t address) {
  const auto [at, is_new] = functions_.try_emplace(address);
  Function& function = at->second;
  if (!is_new) return function;
  look_for(address);
  Dwfl_Module* file = dwfl_addrmodule(dwfl_, address);
  if (file == nullptr) {
    function.name = fmt::format("{:#x}", address);
  } else if (const char* name = dwfl_module_addrname(file, address)) {
    function = {.name = demangled(name), .known = true};
  } else {
    Dwarf_Addr begin = 0;
    const char* path =
        dwfl_module_info(file, nullptr, &begin, nullptr, nullptr, nullptr, nullptr, nullptr);
    function.name = fmt::format("{} + {:#x}", base_name(path), address - begin);
  }
  return function;
}

std::string Unwinder::source(std::uint64_t address) const {
  Dwfl_Line* line = dwfl_getsrc(dwfl_, address);
  int number = 0;
  const char* path =
      line == nullptr ? nullptr : dwfl_lineinfo(line, nullptr, &number, nullptr, nullptr, nullptr);
  return path == nullptr ? std::string() : fmt::format("{}:{}", base_name(path), number);
}

}  // namespace rack
