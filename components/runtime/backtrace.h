// Who called whom, with names: of a thread as it is now, as it was when a signal came, and as the
// kernel saw it a while ago.
//
// Three things are needed. Which file is loaded where: asked of the dynamic linker beforehand, as a
// program that crashes may hold its lock. How to step from a function to its caller: by the tables
// that the compiler leaves in every program (.eh_frame_hdr), also through functions without frame
// pointers; libunwind walks them over memory that we read for it, as its own local unwinding asks
// the dynamic linker. What a function is called: by the file's table of symbols.
//
// Why not libdw: it allocates, and the same must work in a handler after a crash.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <ucontext.h>

#include "components/runtime/logic/perf_records.h"

namespace rack {

// --- The program and its libraries as the dynamic linker has loaded them: where each lies, and
// where its unwind tables are. Kept, because to ask the dynamic linker takes a lock that whoever
// crashes may never get.

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

// --- Names of the functions at addresses of this program and its libraries.

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

// --- Who called whom, found by the tables that the compiler leaves in every program: also through
// functions without frame pointers, of a thread that has run on meanwhile.

// Where a frame's code is found: a call returns to the instruction behind it, which may belong to
// the next function already. The innermost frame (0) is in no call.
constexpr std::uint64_t code_of_frame(std::size_t index, std::uint64_t address) {
  return index == 0 ? address : address - 1;
}

class Unwinder {
 public:
  Unwinder();
  Unwinder(const Unwinder&) = delete;
  Unwinder& operator=(const Unwinder&) = delete;
  ~Unwinder();

  // Innermost first, into `frames`; at least what the snapshot's frame pointers say.
  std::span<std::uint64_t> frames(const Snapshot& snapshot, std::span<std::uint64_t> frames);
  // Of the thread that calls this, as it was when a signal came. Allocates nothing, takes no lock,
  // and survives a damaged stack. A library that was loaded since the Unwinder was made ends it.
  std::span<std::uint64_t> frames(const ucontext_t& context, std::span<std::uint64_t> frames);
  [[nodiscard]] const LoadedFiles& files() const { return files_; }

 private:
  LoadedFiles files_;
  void* space_;
};

}  // namespace rack
