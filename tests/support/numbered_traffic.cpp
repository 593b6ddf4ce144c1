#include "tests/support/numbered_traffic.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "os/clock.h"
#include "tests/support/patience.h"
#include "tims/message.h"

namespace tims::test {
namespace {

using namespace std::chrono_literals;

constexpr std::int8_t kCommand = 21;
constexpr std::size_t kLarge = 20'000;
constexpr std::uint32_t kSlots = 4096;  // what waits while the link is silent arrives at once

std::size_t size_of(std::uint64_t number) { return number % 50 == 0 ? kLarge : 64; }

Result<Session> connect(const NumberedTraffic::End& end) {
  return Session::connect({.name = "numbers",
                           .router = end.router,
                           .timeout = kPatience,
                           .on_event = [](const SessionEvent&) {}});
}

}  // namespace

Result<std::unique_ptr<NumberedTraffic>> NumberedTraffic::begin(const End& from, const End& to,
                                                                Duration pace) {
  auto left = connect(from);
  if (!left) return left.error();
  auto right = connect(to);
  if (!right) return right.error();
  auto source = left->open({.address = from.address, .body_max = 64});
  if (!source) return source.error();
  auto sink = right->open({.address = to.address, .slots = kSlots, .body_max = kLarge});
  if (!sink) return sink.error();
  return std::unique_ptr<NumberedTraffic>(new NumberedTraffic(
      std::move(*left), std::move(*right), std::move(*source), std::move(*sink), pace));
}

NumberedTraffic::NumberedTraffic(Session&& from, Session&& to, Mailbox&& source, Mailbox&& sink,
                                 Duration pace)
    : from_(std::move(from)),
      to_(std::move(to)),
      source_(std::move(source)),
      sink_(std::move(sink)),
      pace_(pace),
      sender_([this] { send(); }),
      receiver_([this] { receive(); }) {}

NumberedTraffic::~NumberedTraffic() { end({}); }

// Until the path is known. What is answered with NOT_AVAILABLE before does not count.
void NumberedTraffic::find_path() {
  constexpr std::uint64_t kNone = 0;
  while (sends_ && !is_found_) {
    (void)source_.send({.dest = sink_.address(), .type = kCommand},
                       std::as_bytes(std::span(&kNone, 1)));
    std::this_thread::sleep_for(1ms);
  }
  while (sends_ && source_.peek_for(50ms)) {
  }
}

void NumberedTraffic::send() {
  find_path();
  std::vector<std::byte> body(kLarge);
  for (std::uint64_t number = 1; sends_; ++number) {
    std::memcpy(body.data(), &number, sizeof number);
    const auto bytes = std::span(body).first(size_of(number));
    while (!source_.send({.dest = sink_.address(), .type = kCommand}, bytes).ok()) {
      if (!sends_) return;
      ++refused_;
      std::this_thread::sleep_for(1ms);
    }
    sent_ = number;
    while (source_.try_peek()) ++wrong_;  // NOT_AVAILABLE
    std::this_thread::sleep_for(pace_);
  }
}

void NumberedTraffic::receive() {
  Time last_at = os::now();
  while (receives_) {
    const auto message = sink_.peek_for(20ms);
    const Time now = os::now();
    if (arrived_ > 0) silence_ns_ = std::max<std::int64_t>(silence_ns_, (now - last_at).count());
    if (!message) continue;
    last_at = now;
    std::uint64_t number = 0;
    if (message->body().size() >= sizeof number)
      std::memcpy(&number, message->body().data(), sizeof number);
    is_found_ = true;
    if (number == 0) continue;
    if (number != arrived_ + 1 || message->body().size() != size_of(number)) ++wrong_;
    arrived_ = number;
  }
}

void NumberedTraffic::end(Duration patience) {
  if (!sender_.joinable()) return;
  sends_ = false;
  sender_.join();
  const Duration silence = this->silence();
  const Time deadline = os::deadline_after(patience);
  while (arrived_ < sent_ && os::now() < deadline) std::this_thread::sleep_for(1ms);
  receives_ = false;
  receiver_.join();
  silence_ns_ = silence.count();
}

}  // namespace tims::test
