// Reads the console from a folder, once, at the start of the router.
#pragma once

#include <string>

#include "router/io/http/console_files.h"
#include "tims/result.h"

namespace tims::io {

// share/tims/console of the installation or build this program belongs to.
std::string default_console_folder();

// All files of the folder and of folders in it. Refuses links, devices and everything else that is
// not a file, without opening it. The error names the file.
Result<ConsoleFiles> read_console(const std::string& folder);

}  // namespace tims::io
