// What is to be recorded: module by module, with the names of the files (specification, section
// 11). Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/datalog.h"
#include "tims/result.h"

namespace rack::datalog {

// A list in a file: lines of an address in hexadecimal, a blank, a file name; an empty line, or the
// end, ends it. Nothing is recorded until SET_LOG says so. kMalformed says in which line.
tims::Result<std::vector<DatalogLogInfo>> read_list(std::string_view text,
                                                    const tims::AddressWidths& widths = {});

// Path and name without what follows its last dot: files of single messages are called so.
std::string base_of(const std::string& path);

}  // namespace rack::datalog
