#include "router/io/dds/route.h"

#include <algorithm>
#include <stdexcept>

#include "router/link/bundle.h"

namespace tims::io {
namespace {

using namespace std::chrono_literals;

constexpr Duration kReaderLimit = 2s;  // for the receiver to appear
constexpr Duration kPauseMax = 250ms;
constexpr Duration kTryAgain = 100us;

}  // namespace

Duration DdsRoute::pause(Duration silent, Duration least) {
  return std::clamp(silent, least, std::max(least, kPauseMax));
}

void DdsRoute::on_heard(Time now) {
  if (silent_since_ == kNever) return;
  answers_in_ = (3 * answers_in_ + silence(now)) / 4;
  silent_since_ = kNever;
  again_at_ = {};
  if (ask_at_ != kNever) ask_at_ = std::min(ask_at_, next_ask(now));
}

// Twice as long as it usually takes, and twice as long each time.
Time DdsRoute::next_ask(Time now) {
  const Duration silence = silent_since_ == kNever ? Duration() : now - silent_since_;
  return now + pause(std::max(silence, 2 * answers_in_), heartbeat_);
}

// From now on, if not longer.
Duration DdsRoute::silence(Time now) {
  silent_since_ = std::min(silent_since_, now);
  return now - silent_since_;
}

Time DdsRoute::serve(Time now, Counters& counters) {
  const Time next = write_next(now, counters);
  return std::min(next, ask(now));
}

Time DdsRoute::ask(Time now) {
  if (!writer_ || now < ask_at_) return ask_at_;
  if (writer_->has_arrived()) return ask_at_ = kNever;
  writer_->ask();
  (void)silence(now);
  return ask_at_ = next_ask(now);
}

Time DdsRoute::write_next(Time now, Counters& counters) {
  if (!writer_ || !peer_->matched) return wait_for_reader(now, counters);
  waits_since_ = kNever;
  if (queue_.waiting_bytes() == 0) return kNever;
  if (now < again_at_) return again_at_;
  const SendQueue::Front front = queue_.front(kSampleBytesMax);
  const Written written = writer_->write({.parts = front.parts});
  if (written == Written::kNever) throw std::runtime_error("a sample could not be written");
  if (written == Written::kNotNow) return again_at_ = now + pause(silence(now), kTryAgain);
  // When it is silent the next question is set already.
  ask_at_ = std::min(ask_at_, now + (silent_since_ == kNever ? heartbeat_ : kPauseMax));
  queue_.remove(front);
  counters.samples += 1;
  counters.datagrams += front.datagrams;
  counters.bytes += front.bytes - front.datagrams * link::kBundleSizeBytes;
  return queue_.waiting_bytes() > 0 ? now : kNever;
}

Time DdsRoute::wait_for_reader(Time now, Counters& counters) {
  if (queue_.waiting_bytes() == 0) {
    waits_since_ = kNever;
    return kNever;
  }
  if (waits_since_ == kNever) waits_since_ = now;
  if (now < waits_since_ + kReaderLimit) return waits_since_ + kReaderLimit;
  const SendQueue::Front all = queue_.front(SendQueue::kBytes);
  queue_.remove(all);
  counters.unmatched += all.datagrams;
  waits_since_ = kNever;
  return kNever;
}

}  // namespace tims::io
