// Passes received data and timeouts to a dialogue and takes its results: live in a driver, and
// again when the recording of a driver is replayed (replay.h).
//
// A stream is passed in slices. The results are taken after each slice, frame, datagram and
// timeout, because a single read may return several telegrams and a dialogue stores the result of
// one only. After a failure, all input is ignored.
#pragma once

#include <functional>
#include <optional>
#include <utility>

#include "rack/devices/dialogue.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

class Conversation {
 public:
  // Takes the results the dialogue has ready. state() returns its error.
  using Take = std::function<tims::Result<void>()>;

  // The dialogue must outlive this object.
  explicit Conversation(Dialogue& dialogue, Take take = {})
      : dialogue_(dialogue), take_(std::move(take)) {}

  void start(Time now, Output& out) { dialogue_.start(now, out); }
  void receive(const Arrival& arrival, Output& out);
  void on_timeout(Time now, Output& out);
  // The dialogue has changed the baud rate: the rest of the current arrival was received at the
  // previous rate and is discarded.
  void drop_rest() { drops_rest_ = true; }
  // The line was closed or lost.
  void end() { has_ended_ = true; }

  // An error if the dialogue has given up the device, or, once, the error of `take`.
  tims::Result<void> state();

 private:
  void receive_piece(const Arrival& piece, Output& out);
  void take();

  Dialogue& dialogue_;
  const Take take_;                     // or none
  std::optional<tims::Error> refused_;  // error of take_
  bool drops_rest_ = false;             // of the current arrival
  bool has_ended_ = false;
};

}  // namespace rack::device

#pragma GCC visibility pop
