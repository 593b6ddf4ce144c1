#include "components/files/whole_file.h"

#include <filesystem>
#include <fstream>
#include <system_error>

#include "os/file.h"

namespace rack {

tims::Result<void> write_file(const std::string& path, std::string_view contents) {
  const std::string fresh = path + ".new";
  std::ofstream file(fresh, std::ios::binary | std::ios::trunc);
  file.write(contents.data(), static_cast<std::streamsize>(contents.size()));
  file.close();
  std::error_code error;
  if (!file) {
    const tims::Error failed = tims::os::system_error(fresh);
    std::filesystem::remove(fresh, error);
    return failed;
  }
  std::filesystem::rename(fresh, path, error);
  if (!error) return {};
  const std::string reason = error.message();
  std::filesystem::remove(fresh, error);
  return tims::Error(tims::Errc::kSystem, path + ": " + reason);
}

}  // namespace rack
