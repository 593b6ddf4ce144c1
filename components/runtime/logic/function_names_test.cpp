#include "components/runtime/logic/function_names.h"

#include <array>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include <elf.h>
#include <gtest/gtest.h>

namespace rack {

namespace {

// Two functions, and nothing else that a real file has.
std::vector<std::byte> small_file() {
  struct Image {
    Elf64_Ehdr header{};
    Elf64_Shdr sections[3]{};
    Elf64_Sym symbols[4]{};
    char names[16] = "\0sweep\0look\0var";
  } image;
  std::memcpy(image.header.e_ident, ELFMAG, SELFMAG);
  image.header.e_ident[EI_CLASS] = ELFCLASS64;
  image.header.e_shoff = offsetof(Image, sections);
  image.header.e_shnum = 3;
  image.sections[1].sh_type = SHT_SYMTAB;
  image.sections[1].sh_offset = offsetof(Image, symbols);
  image.sections[1].sh_size = sizeof image.symbols;
  image.sections[1].sh_link = 2;
  image.sections[2].sh_type = SHT_STRTAB;
  image.sections[2].sh_offset = offsetof(Image, names);
  image.sections[2].sh_size = sizeof image.names;
  const auto symbol = [](std::uint32_t name, unsigned char type, std::uint64_t at,
                         std::uint64_t size) {
    return Elf64_Sym{.st_name = name,
                     .st_info = type,
                     .st_other = 0,
                     .st_shndx = 1,
                     .st_value = at,
                     .st_size = size};
  };
  image.symbols[1] = symbol(12, STT_OBJECT, 0x100, 0x100);
  image.symbols[2] = symbol(1, STT_FUNC, 0x100, 0x20);
  image.symbols[3] = symbol(7, STT_FUNC, 0x120, 0x10);
  const auto bytes = std::as_bytes(std::span(&image, 1));
  return {bytes.begin(), bytes.end()};
}

TEST(ElfSymbols, FindsTheFunctionAroundAnAddress) {
  const auto file = small_file();
  EXPECT_EQ(find_function(file, 0x100).name, "sweep");
  EXPECT_EQ(find_function(file, 0x11F).name, "sweep");
  EXPECT_EQ(find_function(file, 0x11F).offset, 0x1FU);
  EXPECT_EQ(find_function(file, 0x120).name, "look");
  EXPECT_EQ(find_function(file, 0x130).name, "");
}

TEST(ElfSymbols, AFileThatIsNone) {
  EXPECT_EQ(find_function({}, 0x100).name, "");
  const auto file = small_file();
  for (std::size_t size = 0; size < file.size(); ++size)
    (void)find_function(std::span(file).first(size), 0x100);
}

TEST(ElfSymbols, SurvivesDamage) {
  std::minstd_rand random(1);
  for (int round = 0; round < 5000; ++round) {
    auto file = small_file();
    for (int i = 0; i < 4; ++i) file[random() % file.size()] = static_cast<std::byte>(random());
    (void)find_function(file, 0x100 + random() % 0x40);
  }
}

}  // namespace

namespace {

std::string readable(std::string_view mangled) {
  std::array<char, 80> room{};
  return std::string(readable_name(mangled, room));
}

TEST(ReadableName, OfFunctionsAndMembers) {
  EXPECT_EQ(readable("_Z5sweepi"), "sweep");
  EXPECT_EQ(readable("_ZN4rack6Module9data_taskEv"), "rack::Module::data_task");
  EXPECT_EQ(readable("_ZNK4rack6Module5is_onEv"), "rack::Module::is_on");
  EXPECT_EQ(readable("_ZN4rack12_GLOBAL__N_18Offender11module_loopEv"),
            "rack::(anonymous namespace)::Offender::module_loop");
  EXPECT_EQ(readable("_ZN4rack6ModuleC2ERKNS_10ModuleInfoE"), "rack::Module::Module");
  EXPECT_EQ(readable("_ZN4rack6ModuleD0Ev"), "rack::Module::~Module");
}

TEST(ReadableName, WhatIsRareStaysAsItIs) {
  for (const char* name : {"main", "_ZNSt6vectorIiSaIiEE9push_backEOi", "_Z", "_ZN", "_ZN4rack",
                           "_ZN9rackE", "_Z99999999999999999999a", "_ZNE", ""}) {
    EXPECT_EQ(readable(name), name);
  }
}

TEST(ReadableName, IsCutWhereTheRoomEnds) {
  std::array<char, 6> room{};
  EXPECT_EQ(readable_name("_ZN4rack6Module3runEv", room), "rack::");
  EXPECT_EQ(readable_name("clock_nanosleep", room), "clock_");
}

}  // namespace

}  // namespace rack
