// Who called whom, found by the tables that the compiler leaves in every program: also through
// functions without frame pointers, of a thread that has run on meanwhile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <ucontext.h>

#include "components/runtime/loaded_files.h"
#include "components/runtime/logic/snapshot.h"

namespace rack {

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
