// Memory that the processes of one measurement share, identified by the name of a file.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "tims/result.h"

namespace tims::bench {

struct Unmap {
  std::size_t bytes = 0;
  void operator()(std::byte* memory) const;
};
using SharedFile = std::unique_ptr<std::byte[], Unmap>;

// Creates the file if it does not exist; zeroed, with all pages present.
Result<SharedFile> map_shared_file(const std::string& path, std::size_t bytes);
// The same kind of memory for a single process.
Result<SharedFile> map_shared(std::size_t bytes);

}  // namespace tims::bench
