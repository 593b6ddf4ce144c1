// Files that are written as a whole.
#pragma once

#include <string>
#include <string_view>

#include "tims/result.h"

namespace rack {

// Writes a temporary file and renames it, so that a reader gets either the old or the new contents.
// An error names the file; the old contents are then unchanged.
tims::Result<void> write_file(const std::string& path, std::string_view contents);

}  // namespace rack
