// What happened to the samples of each stream on its way to one client that keeps the newest only:
// how many there were, and how many were dropped because a newer one replaced them or others
// needed their room. A bounded number of streams, those with samples most recently. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "tims/address.h"
#include "tims/message.h"

namespace tims::core {

class StreamCounters {
 public:
  static constexpr std::size_t kStreamsMax = 256;

  struct Stream {
    Address src{};
    Address dest{};
    std::int8_t type = 0;
    std::uint64_t samples = 0;  // 0: this place is empty
    std::uint64_t dropped = 0;  // of these
    std::uint32_t waiting = 0;  // of these, in the queue
    std::uint64_t last = 0;     // number of the last sample, of all streams
  };

  static bool is_sample(const Header& header) { return (header.flags & flag::kStream) != 0; }

  // A message came; only samples are counted.
  void add(const Header& header);
  // It waits in the queue; it has left the queue.
  void waits(const Header& header) {
    if (Stream* stream = find(header)) ++stream->waiting;
  }
  void left(const Header& header) {
    Stream* stream = find(header);
    if (stream != nullptr && stream->waiting > 0) --stream->waiting;
  }
  void drop(const Header& header) {
    if (Stream* stream = find(header)) ++stream->dropped;
  }
  // True: a sample of the same stream is in the queue.
  [[nodiscard]] bool has_waiting(const Header& header) const {
    const Stream* stream = find(header);
    return stream != nullptr && stream->waiting > 0;
  }

  template <typename Visit>  // (const Stream&)
  void for_each(Visit visit) const {
    for (const Stream& stream : streams_)
      if (stream.samples > 0) visit(stream);
  }

 private:
  // A stream is in one of the places of its set.
  static constexpr std::size_t kWays = 8;

  [[nodiscard]] const Stream* find(const Header& header) const;
  [[nodiscard]] Stream* find(const Header& header) {
    return const_cast<Stream*>(static_cast<const StreamCounters*>(this)->find(header));
  }
  static std::size_t set_of(const Header& header);

  std::array<Stream, kStreamsMax> streams_{};
  std::uint64_t last_ = 0;
};

}  // namespace tims::core
