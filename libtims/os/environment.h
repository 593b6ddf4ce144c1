// Environment of a program: its variables, its host, and the programs installed next to it.
#pragma once

#include <cstdlib>
#include <functional>
#include <map>
#include <string>

namespace tims::os {

// Returns an empty text when the variable is not set or is empty.
inline std::string environment(const char* name) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return text == nullptr ? "" : text;
}

// All variables with their values.
std::map<std::string, std::string, std::less<>> environment();

// Empty when the host has no name.
std::string host_name();

// Path of a program with this name: in the directory of this program (so that programs of one build
// start each other), else where an installation has its programs; else the name itself, to be found
// through PATH.
std::string find_program(const std::string& name);

}  // namespace tims::os
