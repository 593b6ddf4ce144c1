// Byte vectors written by the original programs: tests/data/vectors.txt, which documents its
// columns.
#pragma once

#include <string>
#include <vector>

#include "tims/message.h"
#include "tims/result.h"

namespace tims::test {

struct GoldenVector {
  std::string name;              // "V30"
  std::string origin;            // "C", "Java", "router", "module", "client"
  Header stated;                 // values of the header according to the specification
  std::vector<std::byte> bytes;  // header and body

  [[nodiscard]] std::span<const std::byte> body() const {
    return std::span(bytes).subspan(kHeaderSize);
  }
};

// All vectors, in the order of the file; an error contains the line number.
Result<std::vector<GoldenVector>> read_golden_vectors();

}  // namespace tims::test
