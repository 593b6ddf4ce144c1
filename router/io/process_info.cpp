#include "router/io/process_info.h"

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

ProcessReport ProcessInfo::process(Time now) const {
  return {.name = configuration_.config.router.name,
          .version = TIMS_VERSION,
          .pid = static_cast<std::uint32_t>(::getpid()),
          .epoch = start.epoch,
          .uptime = now - start.started,
          .rss_bytes = resident_bytes(),
          .longest_turn = loop_.longest_turn(),
          .unix_path = start.unix_path,
          .tcp = start.tcp,
          .http = start.http,
          .udp = start.udp,
          .udp_socket = udp_socket()};
}

std::optional<UdpReport> ProcessInfo::udp_socket() const {
  const UdpSocket* socket = links_.socket();
  if (socket == nullptr) return std::nullopt;
  return UdpReport{.asked_buffer_bytes = socket->asked_buffer_bytes(),
                   .receive_buffer_bytes = socket->receive_buffer_bytes(),
                   .send_buffer_bytes = socket->send_buffer_bytes(),
                   .dropped_by_kernel = socket->counters().dropped_by_kernel};
}

std::optional<DdsReport> ProcessInfo::dds() const {
  const DdsEngine* engine = links_.dds();
  if (engine == nullptr) return std::nullopt;
  const DdsEngine::Counters counters = engine->counters();
  return DdsReport{.state = std::string(name(engine->state())),
                   .trouble = engine->last_error(),
                   .address = engine->address() ? engine->address().to_string() : "",
                   .samples_in = counters.samples_in,
                   .samples_out = counters.samples_out,
                   .datagrams_in = counters.datagrams_in,
                   .datagrams_out = counters.datagrams_out,
                   .strange = counters.strange,
                   .refused = counters.refused,
                   .unmatched = counters.unmatched,
                   .waiting_bytes = counters.waiting_bytes};
}

}  // namespace tims::io
