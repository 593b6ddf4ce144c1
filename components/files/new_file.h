// A file that replaces another one as a whole: it is written beside it under a name of its own and
// then renamed. A reader gets either the old or the new contents; a link, a device or a file with
// another hard link is never written through. It gets the mode of the file that it replaces.
#pragma once

#include <string>
#include <string_view>

#include <sys/types.h>

#include "os/file.h"

namespace rack {

// The error of the last system call on a file. An exceeded quota or file size limit is reported as
// a full disk.
tims::Error file_error(const std::string& path);

class NewFile {
 public:
  // `folder`: a descriptor of the folder, which must stay open. Fails if `name` is there and is not
  // a regular file. A link is replaced, or refused if `links` is false. Errors name `shown`.
  static tims::Result<NewFile> create(int folder, const std::string& name, std::string shown,
                                      bool links);
  NewFile(NewFile&& other) noexcept;
  NewFile& operator=(NewFile&&) = delete;
  ~NewFile();  // removes it unless it was renamed

  // Opened for appending.
  [[nodiscard]] int get() const { return file_.get(); }
  tims::Result<void> write(std::string_view contents);
  tims::Result<void> sync();
  tims::Result<void> rename();
  // After rename().
  [[nodiscard]] tims::os::File release() { return std::move(file_); }

 private:
  NewFile(int folder, std::string name, std::string shown);
  tims::Result<void> open(mode_t mode);
  [[nodiscard]] tims::Error error() const { return file_error(shown_); }

  int folder_;
  std::string name_;
  std::string shown_;
  std::string beside_{};  // empty: renamed, or not created
  tims::os::File file_{};
};

}  // namespace rack
