// Replaces a file atomically and durably: a reader sees the complete old or the complete new text,
// also after a crash or a power failure at any moment.
#pragma once

#include <string>
#include <string_view>

#include <sys/types.h>

#include "tims/result.h"

namespace tims::os {

// Writes the text into a new file beside it, to the disk, and renames it. The mode of an existing
// file is kept, and its owner if that is permitted; a new file gets `mode`. Errors: kSystem, with
// the path and the reason; then the old file is unchanged, unless only the folder could not be
// written to the disk.
Result<void> replace_file(const std::string& path, std::string_view text, mode_t mode = 0644);

// Removes a file, durably. A file that does not exist is no error.
Result<void> remove_file(const std::string& path);

}  // namespace tims::os
