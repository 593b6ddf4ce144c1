// The command line taken apart before anything is known about the verb: words and options.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace timsctl {

struct Words {
  std::vector<std::string> words;    // noun, verb, arguments; also "-" and numbers such as "-6"
  std::vector<std::string> options;  // in one form: "--count=5", "--json"
};

// Throws Failure for options nobody has, and for a value that is missing.
Words split_words(std::span<const std::string> arguments);

}  // namespace timsctl
