#include "components/runtime/logic/function_names.h"

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

namespace {

class Writer {
 public:
  explicit Writer(std::span<char> room) : room_(room) {}
  void put(std::string_view text) {
    const std::size_t size = std::min(text.size(), room_.size() - size_);
    std::copy_n(text.data(), size, room_.data() + size_);
    size_ += size;
  }
  [[nodiscard]] std::string_view text() const { return {room_.data(), size_}; }

 private:
  std::span<char> room_;
  std::size_t size_ = 0;
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// "4rack" and what follows; an empty name when it is none.
std::string_view take_name(std::string_view& rest) {
  std::size_t size = 0;
  std::size_t at = 0;
  for (; at < rest.size() && is_digit(rest[at]) && size < rest.size(); ++at)
    size = size * 10 + static_cast<std::size_t>(rest[at] - '0');
  if (at == 0 || size > rest.size() - at) return {};
  const std::string_view name = rest.substr(at, size);
  rest.remove_prefix(at + size);
  return name;
}

// C1: a constructor; D0: a destructor. They have their class's name.
bool is_special(std::string_view rest, char letter) {
  return rest.size() > 1 && rest[0] == letter && is_digit(rest[1]);
}

// The parts of a name, up to E.
bool write_nested(std::string_view rest, Writer& to) {
  std::string_view last;
  bool first = true;
  while (!rest.empty() && rest.front() != 'E') {
    if (!first) to.put("::");
    if (is_special(rest, 'C') || is_special(rest, 'D')) {
      if (rest[0] == 'D') to.put("~");
      to.put(last);
      rest.remove_prefix(2);
      continue;
    }
    last = take_name(rest);
    if (last.empty()) return false;
    to.put(last.starts_with("_GLOBAL__N") ? "(anonymous namespace)" : last);
    first = false;
  }
  return !rest.empty() && !first;
}

bool write(std::string_view mangled, Writer& to) {
  if (!mangled.starts_with("_Z")) return false;
  mangled.remove_prefix(2);
  if (!mangled.starts_with('N')) {
    const std::string_view name = take_name(mangled);
    to.put(name);
    return !name.empty();
  }
  mangled.remove_prefix(1);
  while (!mangled.empty() && (mangled[0] == 'K' || mangled[0] == 'V')) mangled.remove_prefix(1);
  return write_nested(mangled, to);
}

}  // namespace

std::string_view readable_name(std::string_view mangled, std::span<char> room) {
  Writer to(room);
  if (write(mangled, to)) return to.text();
  Writer as_it_is(room);
  as_it_is.put(mangled);
  return as_it_is.text();
}

}  // namespace rack
