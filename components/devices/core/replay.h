// The recording of a driver (its parameter `record`), made data of again. Pure.
//
// A dialogue knows nothing but what it hears and when it was told which time. A driver records all
// of that, and for each data set that the dialogue made of it a checksum and when it was measured.
// So the same dialogue, started with the same settings, makes the same data of a recording again,
// bit for bit, at once and on any day; the first that are not are kept. What others add to the data
// before they are sent (the clock on the wall, where Position says it is) is not in the sum.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>

#include "components/devices/core/conversation.h"
#include "components/recordings/capture.h"

namespace rack::device {

// FNV-1a, big-endian: the bytes of a record of what was made.
using Checksum = std::array<std::byte, 8>;
Checksum checksum_of(std::span<const std::byte> bytes);

class Replay final : private Output {
 public:
  struct Difference {
    Duration at{};  // in the recording
    std::string text;
  };

  // Of each opening a dialogue, as the driver made it; it has to be there until the next one, or
  // the end. What it has ready is told by made().
  struct Side {
    Dialogue* dialogue = nullptr;
    Conversation::Take take{};
  };
  using MakeSide = std::function<tims::Result<Side>()>;
  explicit Replay(MakeSide make) : make_(std::move(make)) {}

  // Record by record. An error: no dialogue can be made.
  tims::Result<void> take(const CaptureRecord& record);
  void made(Time measured, std::span<const std::byte> message);

  // How often the device was opened.
  [[nodiscard]] std::uint64_t openings() const { return openings_; }
  [[nodiscard]] std::uint64_t messages() const { return messages_; }
  // Of these: not the same, not made any more, or not made then.
  [[nodiscard]] std::uint64_t different() const { return different_; }
  // Messages that cannot be made again: records before them are missing.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  [[nodiscard]] bool is_same() const { return different_ + lost_ == 0; }
  // For people: the first that is different, and how many there are.
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
  // Nobody hears it.
  void send(std::span<const std::byte> /*bytes*/, std::uint32_t /*id*/) override {}
  void set_baud(std::uint32_t /*baud*/) override { conversation_->drop_rest(); }

  MakeSide make_;
  std::optional<Conversation> conversation_;  // none: something is missing
  std::uint32_t records_ = 0;                 // that the dialogue has heard, since it was started
  std::deque<Made> made_;                     // of the last of them
  std::uint64_t openings_ = 0;
  std::uint64_t messages_ = 0;
  std::uint64_t different_ = 0;
  std::uint64_t lost_ = 0;
  std::optional<Difference> first_;
};

}  // namespace rack::device
