#include "components/runtime/logic/elf_symbols.h"

#include <algorithm>
#include <cstring>

#include <elf.h>

namespace rack {
namespace {

class File {
 public:
  explicit File(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::span<const std::byte> part(std::uint64_t offset, std::uint64_t size) const {
    if (offset > bytes_.size() || size > bytes_.size() - offset) return {};
    return bytes_.subspan(offset, size);
  }
  template <typename Value>
  bool read(std::uint64_t offset, Value& value) const {
    const auto from = part(offset, sizeof value);
    if (from.empty()) return false;
    std::memcpy(&value, from.data(), sizeof value);
    return true;
  }

 private:
  std::span<const std::byte> bytes_;
};

bool find_section(const File& file, const Elf64_Ehdr& header, std::uint32_t index,
                  Elf64_Shdr& section) {
  return index < header.e_shnum &&
         file.read(header.e_shoff + std::uint64_t{index} * sizeof section, section);
}

bool find_table(const File& file, const Elf64_Ehdr& header, std::uint32_t type, Elf64_Shdr& table) {
  for (std::uint32_t i = 0; i < header.e_shnum; ++i) {
    if (!find_section(file, header, i, table)) return false;
    if (table.sh_type == type) return true;
  }
  return false;
}

std::string_view name_at(std::span<const std::byte> names, std::uint64_t offset) {
  if (offset >= names.size()) return {};
  const std::string_view rest(reinterpret_cast<const char*>(names.data()) + offset,
                              names.size() - offset);
  const std::size_t end = rest.find('\0');
  return end == std::string_view::npos ? std::string_view() : rest.substr(0, end);
}

bool covers(const Elf64_Sym& symbol, std::uint64_t address) {
  if (ELF64_ST_TYPE(symbol.st_info) != STT_FUNC || symbol.st_shndx == SHN_UNDEF) return false;
  return address >= symbol.st_value &&
         address - symbol.st_value < std::max<std::uint64_t>(symbol.st_size, 1);
}

ElfSymbol search(const File& file, const Elf64_Ehdr& header, const Elf64_Shdr& table,
                 std::uint64_t address) {
  Elf64_Shdr names{};
  if (!find_section(file, header, table.sh_link, names)) return {};
  const auto symbols = file.part(table.sh_offset, table.sh_size);
  Elf64_Sym symbol{};
  for (std::size_t at = 0; at + sizeof symbol <= symbols.size(); at += sizeof symbol) {
    std::memcpy(&symbol, &symbols[at], sizeof symbol);
    if (!covers(symbol, address)) continue;
    return {name_at(file.part(names.sh_offset, names.sh_size), symbol.st_name),
            address - symbol.st_value};
  }
  return {};
}

}  // namespace

ElfSymbol find_function(std::span<const std::byte> file_bytes, std::uint64_t address) {
  const File file(file_bytes);
  Elf64_Ehdr header{};
  if (!file.read(0, header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 ||
      header.e_ident[EI_CLASS] != ELFCLASS64)
    return {};
  // .symtab has all functions; a stripped file has the exported ones in .dynsym.
  for (const std::uint32_t type : {std::uint32_t{SHT_SYMTAB}, std::uint32_t{SHT_DYNSYM}}) {
    Elf64_Shdr table{};
    if (!find_table(file, header, type, table)) continue;
    const ElfSymbol found = search(file, header, table, address);
    if (!found.name.empty()) return found;
  }
  return {};
}

}  // namespace rack
