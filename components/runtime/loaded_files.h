// The program and its libraries as the dynamic linker has loaded them: where each lies, and where
// its unwind tables are. Kept, because to ask the dynamic linker takes a lock that whoever crashes
// may never get.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace rack {

struct LoadedFile {
  std::uint64_t begin = 0;  // of one segment of it
  std::uint64_t end = 0;
  std::uint64_t base = 0;          // where its address 0 would be
  std::uint64_t unwind_table = 0;  // .eh_frame_hdr; 0: it has none
  std::string path{};              // empty: the program's own
};

class LoadedFiles {
 public:
  LoadedFiles() { refresh(); }

  // Libraries may have come and gone. Not for a program that crashes.
  void refresh();
  // Null: no file lies there. Allocates nothing, takes no lock.
  [[nodiscard]] const LoadedFile* find(std::uint64_t address) const;

 private:
  std::vector<LoadedFile> segments_;  // one entry for each that was loaded
};

}  // namespace rack
