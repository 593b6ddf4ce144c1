#include "components/runtime/loaded_files.h"

#include <algorithm>
#include <span>

#include <link.h>

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

}  // namespace rack
