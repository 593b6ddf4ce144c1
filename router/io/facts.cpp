#include "router/io/facts.h"

#include <cstdio>

#include <unistd.h>

namespace tims::io {
namespace {

std::uint64_t resident_bytes() {
  std::uint64_t pages = 0;
  std::FILE* file = std::fopen("/proc/self/statm", "re");
  if (file == nullptr) return 0;
  if (std::fscanf(file, "%*u %lu", &pages) != 1) pages = 0;
  std::fclose(file);
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

ProcessReport Facts::process(Time now) const {
  return {.name = configuration_.config.router.name,
          .version = TIMS_VERSION,
          .pid = static_cast<std::uint32_t>(::getpid()),
          .epoch = start.epoch,
          .uptime = now - start.started,
          .rss_bytes = resident_bytes(),
          .longest_turn = loop_.longest_turn(),
          .unix_path = start.unix_path,
          .tcp = start.tcp,
          .http = start.http};
}

}  // namespace tims::io
