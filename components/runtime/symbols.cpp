#include "components/runtime/symbols.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include <cxxabi.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include "components/runtime/logic/elf_symbols.h"
#include "os/file.h"

namespace rack {
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

}  // namespace rack
