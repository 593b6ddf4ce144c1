#include "components/files/whole_file.h"

#include <filesystem>

#include <fcntl.h>
#include <unistd.h>

#include "components/files/new_file.h"
#include "os/file.h"

namespace rack {

tims::Result<void> write_file(const std::string& path, std::string_view contents) {
  const std::filesystem::path place(path);
  const std::string parent = place.has_parent_path() ? place.parent_path().string() : ".";
  const tims::os::File folder(::open(parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder) return tims::os::system_error(path);
  return write_file_in(folder.get(), place.filename().string(), path, contents, true);
}

tims::Result<void> write_file_in(int folder, const std::string& name, const std::string& shown,
                                 std::string_view contents, bool links) {
  auto file = NewFile::create(folder, name, shown, links);
  if (!file) return file.error();
  if (auto written = file->write(contents); !written) return written;
  if (auto synced = file->sync(); !synced) return synced;
  if (auto renamed = file->rename(); !renamed) return renamed;
  (void)::fsync(folder);  // the new contents are there; only the name may be lost with the power
  return {};
}

}  // namespace rack
