#include "os/environment.h"

#include <array>
#include <filesystem>
#include <string_view>

#include <unistd.h>

namespace tims::os {

namespace fs = std::filesystem;

std::map<std::string, std::string, std::less<>> environment() {
  std::map<std::string, std::string, std::less<>> all;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view line = *entry;
    const std::size_t equals = line.find('=');
    if (equals != std::string_view::npos)
      all.emplace(line.substr(0, equals), line.substr(equals + 1));
  }
  return all;
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::string find_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  std::error_code ignored;
  const fs::path own = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const char* folder : {"", TIMS_BIN_TO_LIBEXEC, TIMS_LIBEXEC_TO_BIN, TIMS_LIBEXEC}) {
    const fs::path path = (own / folder / name).lexically_normal();
    if (::access(path.c_str(), X_OK) == 0) return path;
  }
  return name;
}

}  // namespace tims::os
