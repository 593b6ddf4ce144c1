// A function's name as people write it, made without memory or the C++ library's demangler: for a
// program that crashes. Pure.
#pragma once

#include <span>
#include <string_view>

namespace rack {

// "_ZN4rack6Module9data_taskEv" is "rack::Module::data_task". Names with templates and other rare
// things stay as they are. Returns what was written to `room`, cut where it ends.
std::string_view readable_name(std::string_view mangled, std::span<char> room);

}  // namespace rack
