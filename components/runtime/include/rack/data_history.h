// The last data sets that a component has published, found again by the time of their recording:
// who asks for the data of a moment gets the data set nearest to it, or the two around it, to
// interpolate between.
//
// It is a ring of places of one size that are allocated once; the oldest data set makes room for
// the next. One of the places is the workspace, where the next one is made; it is never read. Time
// stamps wrap, so times are compared by their difference. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>
#include <vector>

#include "rack/codec/quantity.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

class DataHistory {
 public:
  struct Entry {
    TimeStamp recorded = 0;
    std::span<const std::byte> body{};  // as it was published
  };
  enum class Miss : std::uint8_t { kEmpty, kTooOld, kTooNew };

  // `places`: data sets it can hold, the workspace included; at least 2. `size_max`: of each,
  // bytes.
  DataHistory(std::uint32_t places, std::size_t size_max);

  [[nodiscard]] std::span<std::byte> workspace();
  // The first `size` bytes of the workspace are the newest data set now.
  void publish(TimeStamp recorded, std::size_t size);
  void clear();

  [[nodiscard]] std::uint32_t size() const { return held_; }
  [[nodiscard]] const Entry& newest() const { return entry(0); }  // of those there are
  [[nodiscard]] const Entry& oldest() const { return entry(held_ - 1); }

  // The data set recorded nearest to `time`; of two equally near the later one. kTooNew: more than
  // `ahead` after the newest.
  [[nodiscard]] std::variant<Entry, Miss> nearest(TimeStamp time,
                                                  std::chrono::milliseconds ahead) const;

  // The neighbours of `time`: `before` is the last one not after it, except that with a time after
  // the newest both are the newest two.
  struct Pair {
    Entry before;
    Entry after;
  };
  [[nodiscard]] std::variant<Pair, Miss> around(TimeStamp time,
                                                std::chrono::milliseconds ahead) const;

 private:
  // n data sets before the newest.
  [[nodiscard]] const Entry& entry(std::uint32_t n) const {
    return entries_[(workspace_ + entries_.size() - 1 - n) % entries_.size()];
  }
  [[nodiscard]] std::variant<std::uint32_t, Miss> not_after(TimeStamp time,
                                                            std::chrono::milliseconds ahead) const;

  const std::size_t stride_;
  std::unique_ptr<std::byte[]> bytes_;
  std::vector<Entry> entries_;
  std::uint32_t workspace_ = 0;
  std::uint32_t held_ = 0;
};

}  // namespace rack

#pragma GCC visibility pop
