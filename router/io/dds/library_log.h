// Fast DDS has one log a process; it tells the engine that was started last.
#pragma once

#include <memory>

#include "router/io/dds/news.h"

namespace tims::io {

// As long as `news` lives. Nothing goes to the terminal any more.
void send_library_log_to(const std::shared_ptr<DdsNews>& news);

}  // namespace tims::io
