#include "components/devices/core/conversation.h"

#include "components/devices/core/pieces.h"

namespace rack::device {
namespace {

// Of a stream: no two telegrams with data end in so few bytes.
constexpr std::size_t kSliceBytes = 16;

}  // namespace

void Conversation::hear(const Arrival& arrival, Output& out) {
  if (arrival.is_sent) return dialogue_.on_sent(arrival);
  if (arrival.id != 0) return hear_piece(arrival, out);
  drops_rest_ = false;
  in_pieces(arrival, kSliceBytes, [&](const Arrival& piece) {
    if (!drops_rest_) hear_piece(piece, out);
  });
}

void Conversation::tell_time(Time now, Output& out) {
  dialogue_.on_timeout(now, out);
  take();
}

// What comes behind an error is of a device that is opened again.
void Conversation::hear_piece(const Arrival& piece, Output& out) {
  if (has_ended_ || refused_ || dialogue_.failure()) return;
  dialogue_.on_arrival(piece, out);
  take();
}

void Conversation::take() {
  if (!take_ || refused_) return;
  if (auto taken = take_(); !taken) refused_ = taken.error();
}

tims::Result<void> Conversation::state() {
  if (refused_) return *std::exchange(refused_, {});
  if (dialogue_.failure()) return *dialogue_.failure();
  return {};
}

}  // namespace rack::device
