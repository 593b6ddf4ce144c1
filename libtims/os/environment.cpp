#include "os/environment.h"

#include <filesystem>

#include <unistd.h>

namespace tims::os {

namespace fs = std::filesystem;

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
