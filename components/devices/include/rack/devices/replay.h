// Replays the recording of a driver (parameter `record`) and compares the resulting data. Pure.
//
// The result of a dialogue depends only on its settings, on the bytes it receives and on the times
// it is called with. A driver records these bytes and times, and a checksum and a measurement time
// for each data set. The same dialogue with the same settings must produce the same data from the
// recording, bit for bit; the first difference is stored. The checksum excludes values that other
// sources add before the data are sent (wall-clock time, the position from Position).
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>

#include "rack/devices/capture.h"
#include "rack/devices/conversation.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

// FNV-1a, big-endian: the content of a record of one data set.
using Checksum = std::array<std::byte, 8>;
Checksum checksum_of(std::span<const std::byte> bytes);

class Replay final : private Output {
 public:
  struct Difference {
    Duration at{};  // time in the recording
    std::string text;
  };

  // One dialogue for each opening of the device, created as in the driver. It must exist until the
  // next opening or the end. Its results are reported with made().
  struct Side {
    Dialogue* dialogue = nullptr;
    Conversation::Take take{};
  };
  using MakeSide = std::function<tims::Result<Side>()>;
  explicit Replay(MakeSide make) : make_(std::move(make)) {}

  // Takes the next record. Fails if the dialogue cannot be created.
  tims::Result<void> take(const CaptureRecord& record);
  void made(Time measured, std::span<const std::byte> message);

  // Number of times the device was opened.
  [[nodiscard]] std::uint64_t openings() const { return openings_; }
  [[nodiscard]] std::uint64_t messages() const { return messages_; }
  // Number of data sets that differ, are missing now, or were missing in the recording.
  [[nodiscard]] std::uint64_t different() const { return different_; }
  // Number of data sets that cannot be reproduced because records before them are missing.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  [[nodiscard]] bool is_same() const { return different_ + lost_ == 0; }
  // Text for the user: the first difference and the number of differences.
  [[nodiscard]] std::string report() const;
  [[nodiscard]] const std::optional<Difference>& first_difference() const { return first_; }

 private:
  struct Made {
    Duration measured{};
    Checksum checksum{};
  };

  tims::Result<void> start(const CaptureRecord& record);
  void compare(const CaptureRecord& record);
  void count_unmatched(Duration at);
  void differs(Duration at, std::string text);
  // There is no device in a replay: output is discarded.
  void send(std::span<const std::byte> /*bytes*/, std::uint32_t /*id*/) override {}
  void set_baud(std::uint32_t /*baud*/) override { conversation_->drop_rest(); }

  MakeSide make_;
  std::optional<Conversation> conversation_;  // empty if records are missing
  std::uint32_t records_ = 0;                 // passed to the dialogue since its start
  std::deque<Made> made_;                     // results of the last record
  std::uint64_t openings_ = 0;
  std::uint64_t messages_ = 0;
  std::uint64_t different_ = 0;
  std::uint64_t lost_ = 0;
  std::optional<Difference> first_;
};

}  // namespace rack::device

#pragma GCC visibility pop
