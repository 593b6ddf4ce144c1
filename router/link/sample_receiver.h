// Samples of streams on their way in: hands on what came whole. What is in part is kept for a while
// among few others; a sample that comes after a newer one of its stream is thrown away.
#pragma once

#include <array>
#include <cstdint>

#include "router/link/frame.h"
#include "router/link/lane_receiver.h"
#include "router/link/range_set.h"
#include "router/link/record.h"

namespace tims::link {

class SampleReceiver {
 public:
  explicit SampleReceiver(Assembly& assembly) : assembly_(assembly) {}

  // False: it is no sample.
  bool on_frame(Time now, const SampleFrame& frame, Arrivals& arrivals);
  // Of what has come in part, the rest is not waited for longer than this.
  static constexpr Duration kPatience = std::chrono::seconds(2);
  void expire(Time now);
  void clear();

  [[nodiscard]] std::uint64_t incomplete() const { return incomplete_; }  // given up
  [[nodiscard]] std::uint64_t overtaken() const { return overtaken_; }

 private:
  static constexpr std::size_t kPartsMax = 8;   // samples in part
  static constexpr std::size_t kStreams = 128;  // whose newest number is remembered
  // Parts are taken so far ahead: this, and so many times what has come.
  static constexpr std::size_t kAheadMin = 64 << 10;
  static constexpr std::size_t kAheadTimes = 4;

  struct Part {
    std::uint32_t number = 0;
    std::uint32_t total = 0;
    Time since{};
    MessageBuffer bytes{};
    std::size_t received = 0;  // bytes
    RangeSet have{};
  };
  struct Stream {
    Address src{};
    Address dest{};
    std::int8_t type = 0;
    std::uint32_t newest = 0;  // 0: none yet
  };

  Part* part_for(Time now, const SampleFrame& frame);
  void give_up(Part& part);
  bool hand_on(Time now, std::uint8_t hops, std::uint32_t number, std::span<std::byte> message,
               Arrivals& arrivals);

  Assembly& assembly_;
  std::array<Part, kPartsMax> parts_;
  std::array<Stream, kStreams> streams_;  // by a hash of what makes a stream
  std::uint64_t incomplete_ = 0;
  std::uint64_t overtaken_ = 0;
};

}  // namespace tims::link
