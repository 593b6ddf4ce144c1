// The last data sets that a component has published, accessible by recording time: a request for a
// time gets the nearest data set, or the two around it for interpolation.
//
// A ring of slots of equal size, allocated once; the oldest data set is overwritten. One of the
// slots is the workspace, where the next data set is built; it is never read. Time stamps wrap, so
// times are compared by their difference. Pure.
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
    std::span<const std::byte> body{};  // as published
  };
  enum class Miss : std::uint8_t { kEmpty, kTooOld, kTooNew };

  // `places`: number of slots including the workspace, at least 2. `size_max`: bytes per data set.
  DataHistory(std::uint32_t places, std::size_t size_max);

  [[nodiscard]] std::span<std::byte> workspace();
  // The first `size` bytes of the workspace become the newest data set.
  void publish(TimeStamp recorded, std::size_t size);
  void clear();

  [[nodiscard]] std::uint32_t size() const { return held_; }
  [[nodiscard]] const Entry& newest() const { return entry(0); }  // requires size() > 0
  [[nodiscard]] const Entry& oldest() const { return entry(held_ - 1); }

  // The data set nearest to `time`; of two equally near, the later one. kTooNew: more than `ahead`
  // after the newest.
  [[nodiscard]] std::variant<Entry, Miss> nearest(TimeStamp time,
                                                  std::chrono::milliseconds ahead) const;

  // The neighbours of `time`: `before` is the last one not after it; for a time after the newest,
  // both are the newest two.
  struct Pair {
    Entry before;
    Entry after;
  };
  [[nodiscard]] std::variant<Pair, Miss> around(TimeStamp time,
                                                std::chrono::milliseconds ahead) const;

 private:
  // The n-th data set before the newest.
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
