// The protocol between a driver and its device, without any I/O. Inputs are received bytes or
// frames and the current time; outputs are bytes to send and the time of the next timeout. A
// dialogue never blocks: a pause is a timeout. Each dialogue can therefore be tested with every
// split of a recording, with lost answers and with a virtual clock, and the same code runs over a
// serial line, TCP, CAN or a file.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rack/devices/retry_timer.h"
#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

using tims::Duration;
using tims::Time;

// Received data: some bytes of a stream, one datagram, or one frame.
struct Arrival {
  std::span<const std::byte> bytes{};
  Time first{};  // when the first and the last bit were on the line, as exactly as the transport
  Time last{};   // can determine it
  // The identifier of a CAN frame with the flags of SocketCAN, the port of a datagram, the pixel
  // format of a picture; 0 for a stream.
  std::uint32_t id = 0;
  bool is_sent = false;  // in a recording: sent to the device, not received from it
  // Of an emulated device's line, without bytes: the client has changed or gone. Dialogues do not
  // get this: they are started again.
  bool is_restart = false;
};

// Accepts the CAN frames with (frame's id & mask) == (id & mask); the default accepts all.
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
};

// Bytes, or one CAN frame, that are sent later.
struct Telegram {
  std::vector<std::byte> bytes{};
  std::uint32_t id = 0;  // identifier of a CAN frame
};

// Through this interface a dialogue acts on its device. No call fails: the transport reports
// separately that the device cannot be reached.
class Output {
 public:
  virtual ~Output() = default;
  // Sends all bytes, in order of the calls. On CAN, each call sends one frame.
  virtual void send(std::span<const std::byte> bytes, std::uint32_t id = 0) = 0;
  // Sends, or drops the bytes when they could not be sent before the deadline: a motor must not
  // receive an outdated speed.
  virtual void send_before(Time /*deadline*/, std::span<const std::byte> bytes,
                           std::uint32_t id = 0) {
    send(bytes, id);
  }
  // For serial lines, in order with send(); other transports ignore these calls.
  virtual void set_baud(std::uint32_t) {}
  virtual void set_dtr(bool) {}
};

class Dialogue {
 public:
  virtual ~Dialogue() = default;

  // The device has been connected (again): discards all state from the previous connection.
  virtual void start(Time now, Output& out) = 0;
  virtual void on_arrival(const Arrival& arrival, Output& out) = 0;
  virtual void on_timeout(Time /*now*/, Output& /*out*/) {}
  // In a replay: bytes that were sent to the device during the recording. Dialogues whose answers
  // do not name their request use them to interpret the answers.
  virtual void on_sent(const Arrival& /*request*/) {}
  // Called before the device is closed: stops motors, switches lasers off.
  virtual void stop(Time /*now*/, Output& /*out*/) {}
  // Stop commands for the device, which the guard process (io/guard.h) sends when this program ends
  // without stop(). A device that would keep moving needs them. They must not depend on the state
  // of the protocol. Empty: the guard sends nothing.
  [[nodiscard]] virtual std::vector<Telegram> stop_commands() const { return {}; }
  // When to call on_timeout().
  [[nodiscard]] virtual Time next_timeout() const { return timer_.due(); }
  // Filters for the CAN frames this dialogue needs; the kernel discards all others on a busy bus.
  // Empty: the dialogue only sends. The transport itself receives error frames. Frames that match
  // no filter may still arrive.
  [[nodiscard]] virtual std::vector<CanFilter> wanted_frames() const { return {CanFilter{}}; }

  // Why the dialogue has given up the device, for example: it does not answer, or it is a different
  // device. start() tries again.
  [[nodiscard]] const std::optional<tims::Error>& failure() const { return failure_; }

 protected:
  // Also stops the timer.
  void fail(tims::Errc code, std::string why) {
    timer_.stop();
    failure_.emplace(code, std::move(why));
  }
  void clear_failure() { failure_.reset(); }
  // kind: for example "scanner"; wanted: the required serial number, or empty for any. Returns
  // false after fail() if the device found has a different serial number.
  bool is_wanted(const std::string& kind, const std::string& found, const std::string& wanted) {
    const auto capital = [](char c) { return c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c; };
    if (wanted.empty() || std::ranges::equal(found, wanted, {}, capital, capital)) return true;
    fail(tims::Errc::kInvalidArgument,
         found.empty() ? "this " + kind + " reports no serial number; required: " + wanted
                       : "this " + kind + " has serial number " + found + "; required: " + wanted);
    return false;
  }

  RetryTimer timer_;  // of the current request; determines next_timeout()

 private:
  std::optional<tims::Error> failure_;
};

}  // namespace rack::device
