// Files that are written as a whole.
#pragma once

#include <string>
#include <string_view>

#include "tims/result.h"

namespace rack {

// Writes a new file, flushes it to the disk and renames it, so that a reader gets either the old or
// the new contents, also after a loss of power. The mode of an existing file stays. An error names
// the file; the old contents are then unchanged.
tims::Result<void> write_file(const std::string& path, std::string_view contents);

// As above, in an open folder (new_file.h).
tims::Result<void> write_file_in(int folder, const std::string& name, const std::string& shown,
                                 std::string_view contents, bool links);

}  // namespace rack
