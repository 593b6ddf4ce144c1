// Names of functions for a program that crashes: found in the tables of an ELF file, and made
// readable, without memory of their own or the C++ library's demangler. Whatever the file holds,
// nothing behind its end is read. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace rack {

// --- Names of functions in an ELF file of 64 bits, also of those that are not exported. Pure, and
// without memory of its own: this is asked while a program crashes.

struct ElfSymbol {
  std::string_view name{};   // as the linker knows it; points into the file
  std::uint64_t offset = 0;  // of the address, from the function's beginning
};

// The function around `address`, as the file counts addresses; an empty name: there is none, or the
// file is damaged.
ElfSymbol find_function(std::span<const std::byte> file_bytes, std::uint64_t address);

// --- A function's name as people write it, made without memory or the C++ library's demangler: for
// a program that crashes. Pure.

// "_ZN4rack6Module9data_taskEv" is "rack::Module::data_task". Names with templates and other rare
// things stay as they are. Returns what was written to `room`, cut where it ends.
std::string_view readable_name(std::string_view mangled, std::span<char> room);

}  // namespace rack
