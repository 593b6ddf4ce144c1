// The configuration files of a host: router.toml, router.d/NAME.toml and robots/NAME.toml in one
// folder. Other names, links and devices are none, whatever a question says.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "tims/result.h"

namespace timsctl::configuration {

inline constexpr std::size_t kFileMax = 60'000;  // bytes, as of a robot file
inline constexpr std::size_t kFilesMax = 64;

using Texts = std::map<std::string, std::string, std::less<>>;  // by the name of the file

bool is_file_name(std::string_view name);
bool is_robot_file(std::string_view name);  // else a router's
// 16 hex digits (FNV-1a): to notice another editor, not to prove anything.
std::string hash_of(std::string_view text);

class Folder {
 public:
  explicit Folder(std::string path) : path_(std::move(path)) {}

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string path_of(std::string_view name) const {
    return path_ + "/" + std::string(name);
  }
  // All files. kTooBig: too many, or one is too large.
  [[nodiscard]] tims::Result<Texts> read() const;
  // The files become these: what differs is replaced, one after the other, what is not among them
  // is removed.
  [[nodiscard]] tims::Result<void> write(const Texts& wanted) const;

 private:
  std::string path_;
};

}  // namespace timsctl::configuration
