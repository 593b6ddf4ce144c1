#include "components/runtime/backtrace.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>

#include <cxxabi.h>
#include <fcntl.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include "components/runtime/logic/function_names.h"
#include "components/runtime/registers.h"
#include "os/file.h"

// Exported for programs that look at others, as we do at our own past; no header declares it (the
// kernel's perf declares it in the same way). That it is there is checked when we are configured.
extern "C" int UNW_OBJ(dwarf_search_unwind_table)(unw_addr_space_t space, unw_word_t address,
                                                  unw_dyn_info_t* table, unw_proc_info_t* info,
                                                  int need_unwind_info, void* thread);

namespace rack {

namespace {

int add_file(dl_phdr_info* file, std::size_t, void* data) {
  auto& segments = *static_cast<std::vector<LoadedFile>*>(data);
  const std::span parts(file->dlpi_phdr, file->dlpi_phnum);
  const auto table = std::ranges::find(parts, PT_GNU_EH_FRAME, &ElfW(Phdr)::p_type);
  for (const auto& part : parts) {
    if (part.p_type != PT_LOAD) continue;
    const std::uint64_t begin = file->dlpi_addr + part.p_vaddr;
    segments.push_back({.begin = begin,
                        .end = begin + part.p_memsz,
                        .base = file->dlpi_addr,
                        .unwind_table = table == parts.end() ? 0 : file->dlpi_addr + table->p_vaddr,
                        .path = file->dlpi_name});
  }
  return 0;
}

}  // namespace

void LoadedFiles::refresh() {
  segments_.clear();
  ::dl_iterate_phdr(add_file, &segments_);
}

const LoadedFile* LoadedFiles::find(std::uint64_t address) const {
  const auto found = std::ranges::find_if(
      segments_, [&](const LoadedFile& s) { return s.begin <= address && address < s.end; });
  return found == segments_.end() ? nullptr : &*found;
}

namespace {

constexpr const char* kOwnFile = "/proc/self/exe";

// A whole file to look at.
class FileView {
 public:
  explicit FileView(const char* path) : file_(::open(path, O_RDONLY | O_CLOEXEC)) {
    struct stat status {};
    if (!file_ || ::fstat(file_.get(), &status) != 0) return;
    const auto size = static_cast<std::size_t>(status.st_size);
    void* memory = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file_.get(), 0);
    if (memory != MAP_FAILED) bytes_ = {static_cast<const std::byte*>(memory), size};
  }
  FileView(const FileView&) = delete;
  FileView& operator=(const FileView&) = delete;
  ~FileView() {
    if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  tims::os::File file_;
  std::span<const std::byte> bytes_;
};

std::string_view base_name(std::string_view path) { return path.substr(path.rfind('/') + 1); }

std::string demangled(std::string_view name) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> text(
      abi::__cxa_demangle(std::string(name).c_str(), nullptr, nullptr, &status), &std::free);
  return status == 0 ? text.get() : std::string(name);
}

std::string hex(std::uint64_t number) {
  std::array<char, 20> text{};
  std::snprintf(text.data(), text.size(), "0x%llx", static_cast<unsigned long long>(number));
  return text.data();
}

}  // namespace

Symbol find_symbol(const LoadedFiles& files, std::uint64_t address, std::span<char> room) {
  const LoadedFile* loaded = files.find(address);
  if (loaded == nullptr) return {.offset = address, .file = "?"};
  const bool own = loaded->path.empty();
  Symbol symbol{.offset = address - loaded->base, .file = base_name(loaded->path)};
  const FileView file(own ? kOwnFile : loaded->path.c_str());
  const ElfSymbol found = find_function(file.bytes(), symbol.offset);
  if (found.name.empty()) return symbol;
  const std::size_t size = std::min(found.name.size(), room.size());
  std::copy_n(found.name.data(), size, room.data());
  symbol.name = {room.data(), size};
  symbol.offset = found.offset;
  return symbol;
}

const SymbolNames::Name& SymbolNames::name(std::uint64_t address) {
  const auto [at, is_new] = names_.try_emplace(address);
  if (!is_new) return at->second;
  std::array<char, 1024> room{};
  if (files_.find(address) == nullptr) files_.refresh();
  const Symbol symbol = find_symbol(files_, address, room);
  at->second.known = !symbol.name.empty();
  at->second.text = at->second.known ? demangled(symbol.name)
                                     : std::string(symbol.file) + " + " + hex(symbol.offset);
  return at->second;
}

namespace {

// The thread that is looked at: its registers, and what its stack was.
struct Thread {
  const LoadedFiles& files;
  std::array<unw_word_t, 32> registers{};
  std::span<const std::byte> stack{};  // empty: memory as it is now
  std::uint64_t stack_begin = 0;
};

// Registers and tables hold numbers.
void* pointer(std::uint64_t address) {
  return reinterpret_cast<void*>(address);  // NOLINT(performance-no-int-to-ptr)
}

// Reads no memory that is not there.
bool read_memory(std::uint64_t address, unw_word_t& value) {
  const iovec to{&value, sizeof value};
  const iovec from{pointer(address), sizeof value};
  return ::process_vm_readv(::getpid(), &to, 1, &from, 1, 0) == sizeof value;
}

int access_memory(unw_addr_space_t, unw_word_t address, unw_word_t* value, int write,
                  void* thread) {
  if (write != 0) return -UNW_EINVAL;
  const Thread& of = *static_cast<const Thread*>(thread);
  const std::uint64_t offset = address - of.stack_begin;
  if (offset < of.stack.size() && sizeof *value <= of.stack.size() - offset) {
    std::memcpy(value, &of.stack[offset], sizeof *value);
    return 0;
  }
  return read_memory(address, *value) ? 0 : -UNW_EINVAL;
}

int access_register(unw_addr_space_t, unw_regnum_t number, unw_word_t* value, int write,
                    void* thread) {
  const Thread& of = *static_cast<const Thread*>(thread);
  const auto index = static_cast<std::size_t>(number);
  if (write != 0 || index >= of.registers.size()) return -UNW_EBADREG;
  *value = of.registers[index];
  return 0;
}

// --- the tables (.eh_frame_hdr) of the loaded file around an address

// As all linkers write it: sorted pairs of numbers, relative to the header itself.
struct TableHeader {
  std::uint8_t version;
  std::uint8_t frame_encoding;
  std::uint8_t count_encoding;
  std::uint8_t table_encoding;
  std::int32_t frame;
  std::uint32_t count;
};
constexpr std::uint8_t kFourBytes = 0x03;
constexpr std::uint8_t kPairs = 0x3B;

bool describe_table(unw_word_t at, unw_dyn_info_t& table) {
  TableHeader header{};
  std::memcpy(&header, pointer(at), sizeof header);
  if (header.version != 1 || header.count_encoding != kFourBytes || header.table_encoding != kPairs)
    return false;
  table.format = UNW_INFO_FORMAT_REMOTE_TABLE;
  table.u.rti.segbase = at;
  table.u.rti.table_data = at + sizeof header;
  table.u.rti.table_len =
      std::uint64_t{header.count} * 2 * sizeof(std::int32_t) / sizeof(unw_word_t);
  return true;
}

int find_procedure(unw_addr_space_t space, unw_word_t address, unw_proc_info_t* info, int need,
                   void* thread) {
  const LoadedFile* file = static_cast<const Thread*>(thread)->files.find(address);
  if (file == nullptr || file->unwind_table == 0) return -UNW_ENOINFO;
  unw_dyn_info_t table{};
  table.start_ip = file->begin;
  table.end_ip = file->end;
  if (!describe_table(file->unwind_table, table)) return -UNW_ENOINFO;
  return UNW_OBJ(dwarf_search_unwind_table)(space, address, &table, info, need, thread);
}

void put_unwind_info(unw_addr_space_t, unw_proc_info_t*, void*) {}
int no_list(unw_addr_space_t, unw_word_t*, void*) { return -UNW_ENOINFO; }
int no_float(unw_addr_space_t, unw_regnum_t, unw_fpreg_t*, int, void*) { return -UNW_EBADREG; }
int no_resume(unw_addr_space_t, unw_cursor_t*, void*) { return -UNW_EINVAL; }
int no_name(unw_addr_space_t, unw_word_t, char*, std::size_t, unw_word_t*, void*) {
  return -UNW_ENOINFO;
}

// --- walking

std::span<std::uint64_t> walk(void* space, Thread& thread, std::span<std::uint64_t> frames) {
  unw_cursor_t cursor;
  if (unw_init_remote(&cursor, static_cast<unw_addr_space_t>(space), &thread) != 0) return {};
  std::size_t found = 0;
  while (found < frames.size()) {
    unw_word_t address = 0;
    if (unw_get_reg(&cursor, UNW_REG_IP, &address) != 0 || address == 0) break;
    frames[found++] = address;
    if (unw_step(&cursor) <= 0) break;
  }
  return frames.first(found);
}

Thread thread_of(const LoadedFiles& files, const Snapshot& snapshot) {
  Thread thread{.files = files};
  for (std::size_t i = 0; i < kRegisterNames.size(); ++i)
    thread.registers[static_cast<std::size_t>(kRegisterNames[i].unwinder)] = snapshot.registers[i];
  thread.stack = std::span(snapshot.stack).first(snapshot.stack_size);
  return thread;
}

Thread thread_of(const LoadedFiles& files, const ucontext_t& context) {
  Thread thread{.files = files};
  for (const RegisterName& name : kRegisterNames)
    thread.registers[static_cast<std::size_t>(name.unwinder)] =
        static_cast<unw_word_t>(context.uc_mcontext.gregs[name.signal]);
  return thread;
}

}  // namespace

Unwinder::Unwinder() {
  static unw_accessors_t accessors = {
      .find_proc_info = find_procedure,
      .put_unwind_info = put_unwind_info,
      .get_dyn_info_list_addr = no_list,
      .access_mem = access_memory,
      .access_reg = access_register,
      .access_fpreg = no_float,
      .resume = no_resume,
      .get_proc_name = no_name,
  };
  unw_addr_space_t space = unw_create_addr_space(&accessors, 0);
  if (space != nullptr) unw_set_caching_policy(space, UNW_CACHE_NONE);
  space_ = space;
}

Unwinder::~Unwinder() {
  if (space_ != nullptr) unw_destroy_addr_space(static_cast<unw_addr_space_t>(space_));
}

std::span<std::uint64_t> Unwinder::frames(const Snapshot& snapshot,
                                          std::span<std::uint64_t> frames) {
  if (space_ != nullptr && !kRegisterNames.empty() &&
      snapshot.register_count == kRegisterNames.size()) {
    files_.refresh();
    Thread thread = thread_of(files_, snapshot);
    thread.stack_begin = thread.registers[UNW_TDEP_SP];
    const auto found = walk(space_, thread, frames);
    if (found.size() > 1) return found;
  }
  const auto chain = snapshot.frames();
  const std::size_t size = std::min(chain.size(), frames.size());
  std::copy_n(chain.begin(), size, frames.begin());
  return frames.first(size);
}

std::span<std::uint64_t> Unwinder::frames(const ucontext_t& context,
                                          std::span<std::uint64_t> frames) {
  if (space_ == nullptr || kRegisterNames.empty()) return {};
  Thread thread = thread_of(files_, context);
  return walk(space_, thread, frames);
}

}  // namespace rack
