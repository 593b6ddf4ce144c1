#include "rack/devices/conversation.h"

#include "rack/devices/pieces.h"

namespace rack::device {
namespace {

// Slice of a stream: so short that at most one telegram with data ends in it.
constexpr std::size_t kSliceBytes = 16;

}  // namespace

void Conversation::receive(const Arrival& arrival, Output& out) {
  if (arrival.is_sent) return dialogue_.on_sent(arrival);
  if (arrival.id != 0) return receive_piece(arrival, out);
  drops_rest_ = false;
  in_pieces(arrival, kSliceBytes, [&](const Arrival& piece) {
    if (!drops_rest_) receive_piece(piece, out);
  });
}

void Conversation::on_timeout(Time now, Output& out) {
  dialogue_.on_timeout(now, out);
  take();
}

// After an error the device is opened again, so the rest of the input is ignored.
void Conversation::receive_piece(const Arrival& piece, Output& out) {
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
