// What lies in a folder and below it, to see that nothing of it has changed.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

namespace tims::test {

// The bytes of each file by its path; of a folder, "/".
inline std::map<std::string, std::string> contents_of(const std::filesystem::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    contents[entry.path().string()] =
        entry.is_directory() ? "/" : std::string(std::istreambuf_iterator<char>(file), {});
  }
  return contents;
}

}  // namespace tims::test
