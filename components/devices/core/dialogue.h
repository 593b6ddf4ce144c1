// How a driver talks with its device, without the device: bytes or frames and the time come in,
// bytes to send and times to be woken at go out. It never waits: a pause is a time to be woken at.
// So each dialogue is tested with every split of a recording, lost answers and a virtual clock, and
// the same code runs over a serial line, TCP, CAN, or a file.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

using tims::Duration;
using tims::Time;

// Some bytes of a stream, a datagram, or a frame, as they came.
struct Arrival {
  std::span<const std::byte> bytes{};
  Time first{};  // when its first and its last bit were on the line, as near as the transport knows
  Time last{};
  // Of a CAN frame, with the flags of SocketCAN; of a datagram the port; of a picture its format.
  // Of a stream 0.
  std::uint32_t id = 0;
  bool is_sent = false;  // of a recording: by the program that talked with the device then
};

// Of CAN: the frames with (frame's id & mask) == (id & mask). By default all of them.
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
};

// What is sent at once, kept for later.
struct Telegram {
  std::vector<std::byte> bytes{};
  std::uint32_t id = 0;  // of CAN
};

// What a dialogue can do to its device. Nothing fails here: whether the device is there is told
// otherwise.
class Output {
 public:
  virtual ~Output() = default;
  // All of it, in order. Of CAN: one frame.
  virtual void send(std::span<const std::byte> bytes, std::uint32_t id = 0) = 0;
  // The same, of what is worthless later: a motor must not hear yesterday's speed.
  virtual void send_before(Time /*deadline*/, std::span<const std::byte> bytes,
                           std::uint32_t id = 0) {
    send(bytes, id);
  }
  // Of serial lines, after what was sent before; elsewhere it does nothing.
  virtual void set_baud(std::uint32_t) {}
  virtual void set_dtr(bool) {}
};

class Dialogue {
 public:
  virtual ~Dialogue() = default;

  // The device can be reached (again): whatever was known of it is no longer.
  virtual void start(Time now, Output& out) = 0;
  virtual void on_arrival(const Arrival& arrival, Output& out) = 0;
  virtual void on_timeout(Time /*now*/, Output& /*out*/) {}
  // Of a recording: what was said to the device then, for who cannot tell answers by themselves.
  virtual void on_sent(const Arrival& /*words*/) {}
  // Before the device is left: motors stop, lasers sleep.
  virtual void stop(Time /*now*/, Output& /*out*/) {}
  // What somebody else tells the device when this program dies without stop(): of those that would
  // drive on. They mean the same whatever was said before. None: nothing is told.
  [[nodiscard]] virtual std::vector<Telegram> last_words() const { return {}; }
  [[nodiscard]] virtual Time next_timeout() const { return tims::kNever; }
  // Of CAN: what it wants to hear, for the kernel to leave out the rest of a busy bus; none: it
  // only speaks. Error frames are heard by the transport. Others may come nevertheless.
  [[nodiscard]] virtual std::vector<CanFilter> wanted_frames() const { return {CanFilter{}}; }

  // Why it gives the device up: it does not answer, or is another one. start() tries again.
  [[nodiscard]] const std::optional<tims::Error>& failure() const { return failure_; }

 protected:
  void fail(tims::Errc code, std::string why) { failure_.emplace(code, std::move(why)); }
  void clear_failure() { failure_.reset(); }
  // kind: "scanner"; wanted: the serial number of the only one that will do, empty: any. False: it
  // is another one, and is given up.
  bool is_wanted(const std::string& kind, const std::string& found, const std::string& wanted) {
    const auto capital = [](char c) { return c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c; };
    if (wanted.empty() || std::ranges::equal(found, wanted, {}, capital, capital)) return true;
    fail(tims::Errc::kInvalidArgument,
         found.empty()
             ? "this " + kind + " tells no serial number, and " + wanted + " is wanted"
             : "this is the " + kind + " with serial number " + found + ", not " + wanted);
    return false;
  }

 private:
  std::optional<tims::Error> failure_;
};

}  // namespace rack::device
