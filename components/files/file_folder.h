// The folder of files whose names come in messages (LOAD_MAP, SAVE_MAP, SET_LOG). Anybody in the
// network can send such a message, therefore it can name only files directly in this folder:
// regular ones, by plain names.
#pragma once

#include <string>
#include <string_view>

#include "os/file.h"
#include "tims/result.h"

namespace rack {

// A name that stays in its folder: no '/', not hidden (and so not "." or ".."), no control
// characters, at most 200 bytes.
bool is_plain_name(std::string_view name);

class FileFolder {
 public:
  explicit FileFolder(std::string path) : path_(std::move(path)) {}
  // That of this host: RACK_FILES in the environment, which the robot file sets ("files"), else
  // rack in $XDG_DATA_HOME or in ~/.local/share. Fails without any of them.
  static tims::Result<FileFolder> of_messages();

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string path_of(std::string_view name) const;

  // The path of a file that is there.
  [[nodiscard]] tims::Result<std::string> existing(std::string_view name) const;
  // Both create the folder if necessary, and replace an existing file by a new one with its mode.
  // The contents are flushed to the disk.
  [[nodiscard]] tims::Result<void> write(std::string_view name, std::string_view contents) const;
  // An empty file, opened for appending.
  [[nodiscard]] tims::Result<tims::os::File> create(std::string_view name) const;

 private:
  [[nodiscard]] tims::Result<tims::os::File> open(std::string_view name) const;

  std::string path_;
};

// The path of a file that a message asks to read. A program of this host may also give the path of
// another file, which it could read itself, or set as a parameter.
tims::Result<std::string> file_to_read(std::string_view name, bool is_foreign);

}  // namespace rack
