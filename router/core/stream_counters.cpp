#include "router/core/stream_counters.h"

#include <algorithm>
#include <span>

#include "router/core/random.h"

namespace tims::core {
namespace {

bool is_of(const StreamCounters::Stream& stream, const Header& header) {
  return stream.samples > 0 && stream.src == header.src && stream.dest == header.dest &&
         stream.type == header.type;
}

}  // namespace

void StreamCounters::add(const Header& header) {
  if (!is_sample(header)) return;
  Stream* stream = find(header);
  if (stream == nullptr) {
    const auto set = std::span(streams_).subspan(set_of(header), kWays);
    stream = &*std::ranges::min_element(set, {}, &Stream::last);
    *stream = {.src = header.src, .dest = header.dest, .type = header.type};
  }
  ++stream->samples;
  stream->last = ++last_;
}

const StreamCounters::Stream* StreamCounters::find(const Header& header) const {
  const auto set = std::span(streams_).subspan(set_of(header), kWays);
  const auto found =
      std::ranges::find_if(set, [&](const Stream& stream) { return is_of(stream, header); });
  return found == set.end() ? nullptr : &*found;
}

std::size_t StreamCounters::set_of(const Header& header) {
  const std::uint64_t key = std::uint64_t{header.src.raw()} << 32 | header.dest.raw();
  const std::uint64_t hash = spread(key + static_cast<std::uint8_t>(header.type));
  return hash % (kStreamsMax / kWays) * kWays;
}

}  // namespace tims::core
