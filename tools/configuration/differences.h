// What differs between two texts of a file: as a unified diff, and as sentences for people. Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace timsctl::configuration {

struct TextDifference {
  std::string diff;  // unified, with three lines around each change; empty: the texts are equal
  std::size_t added = 0;
  std::size_t removed = 0;
};

TextDifference difference(std::string_view name, std::string_view before, std::string_view after);

}  // namespace timsctl::configuration
