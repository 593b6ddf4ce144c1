// A dialogue, and what it hears: as a driver leads it at its device, and again when a recording of
// that is replayed (replay.h).
//
// A stream is handed over in slices, and after each of them, as after each frame, datagram and time
// of the dialogue, what it has made is taken: whoever reads late finds several telegrams at once,
// and a dialogue keeps the result of one. Behind a failure nothing is heard.
#pragma once

#include <functional>
#include <optional>
#include <utility>

#include "components/devices/core/dialogue.h"

namespace rack::device {

class Conversation {
 public:
  // Takes what the dialogue has ready. Its error is that of state().
  using Take = std::function<tims::Result<void>()>;

  // The dialogue must outlive it.
  explicit Conversation(Dialogue& dialogue, Take take = {})
      : dialogue_(dialogue), take_(std::move(take)) {}

  void start(Time now, Output& out) { dialogue_.start(now, out); }
  void hear(const Arrival& arrival, Output& out);
  void tell_time(Time now, Output& out);
  // The dialogue has set another rate: the rest of what is heard came at the one before, and is
  // noise.
  void drop_rest() { drops_rest_ = true; }
  // The line is gone.
  void end() { has_ended_ = true; }

  // Why it cannot go on: the dialogue has given the device up, or once what could not be taken.
  tims::Result<void> state();

 private:
  void hear_piece(const Arrival& piece, Output& out);
  void take();

  Dialogue& dialogue_;
  const Take take_;                     // or none
  std::optional<tims::Error> refused_;  // what was taken
  bool drops_rest_ = false;             // of the arrival that is heard
  bool has_ended_ = false;
};

}  // namespace rack::device
