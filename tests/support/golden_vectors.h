// The golden byte vectors of the original: tests/data/vectors.txt, which explains its columns.
#pragma once

#include <string>
#include <vector>

#include "tims/message.h"
#include "tims/result.h"

namespace tims::test {

struct GoldenVector {
  std::string name;              // "V30"
  std::string origin;            // "C", "Java", "router", "module", "client"
  Header stated;                 // what the specification says the header means
  std::vector<std::byte> bytes;  // header and body

  [[nodiscard]] std::span<const std::byte> body() const {
    return std::span(bytes).subspan(kHeaderSize);
  }
};

// All of them, in the order of the file; an error names the line.
Result<std::vector<GoldenVector>> read_golden_vectors();

}  // namespace tims::test
