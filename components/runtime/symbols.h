// Names of the functions at addresses of this program and its libraries.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "components/runtime/loaded_files.h"

namespace rack {

struct Symbol {
  std::string_view name{};   // of the linker; empty: not known
  std::uint64_t offset = 0;  // from its beginning; without name: from the beginning of the file
  std::string_view file{};   // the library's file name; empty: this program's own
};

// Allocates nothing, takes no lock; names are written to `room`, the file's belongs to `files`.
Symbol find_symbol(const LoadedFiles& files, std::uint64_t address, std::span<char> room);

// For people, remembered. Not for a program that crashes.
class SymbolNames {
 public:
  struct Name {
    std::string text;    // "rack::Module::run(int, char**)", "libc.so.6 + 0x1234"
    bool known = false;  // as a function
  };
  const Name& name(std::uint64_t address);

 private:
  LoadedFiles files_;
  std::unordered_map<std::uint64_t, Name> names_;
};

}  // namespace rack
