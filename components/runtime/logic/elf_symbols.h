// Names of functions in an ELF file of 64 bits, also of those that are not exported. Pure, and
// without memory of its own: this is asked while a program crashes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace rack {

struct ElfSymbol {
  std::string_view name{};   // as the linker knows it; points into the file
  std::uint64_t offset = 0;  // of the address, from the function's beginning
};

// The function around `address`, as the file counts addresses; an empty name: there is none, or the
// file is damaged.
ElfSymbol find_function(std::span<const std::byte> file_bytes, std::uint64_t address);

}  // namespace rack
