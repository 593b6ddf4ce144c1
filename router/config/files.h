// The configuration files of a path, read. The only file of this folder that touches the disk.
#pragma once

#include <filesystem>
#include <vector>

#include "router/config/load.h"
#include "tims/result.h"

namespace tims::config {

// A file: that file, then *.toml of the folder beside it that has its name with ".d"
// (router.toml, router.d/*.toml), in alphabetical order. A folder: its *.toml files.
Result<std::vector<File>> read_files(const std::filesystem::path& path);

}  // namespace tims::config
