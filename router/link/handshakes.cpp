#include "router/link/handshakes.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tims::link {
namespace {

// What both sides know of HELLO and RETRY. Secrets of a handshake that had others differ.
std::array<std::byte, 18> binding_of(std::uint64_t token, std::uint64_t cookie) {
  std::array<std::byte, 18> bytes{};
  ByteWriter out(bytes);
  out.put(kVersionSealed, kVersionSealed, token, cookie);
  return bytes;
}

}  // namespace

Handshakes::One& Handshakes::add(Time now, Side side, const NetAddress& address,
                                 std::uint64_t token, std::uint64_t cookie) {
  const std::uint64_t number = ++last_;
  One& one = all_[number];
  one.number = number;
  one.side = side;
  one.address = address;
  one.token = token;
  one.cookie = cookie;
  one.began = one.heard = now;
  handshaker_->begin(number, side, binding_of(token, cookie));
  return one;
}

void Handshakes::connect(Time now, const NetAddress& to, const Retry& retry,
                         std::span<const std::byte> who, bool restarts) {
  if (One* old = calling(retry.echo)) {
    if (goes_on(now, *old, to, retry, restarts)) return;
    end(old->number);
  }
  const One& one = add(now, Side::kConnects, to, retry.echo, retry.cookie);
  handshaker_->send(one.number, who);
}

// A router that has restarted gives other cookies and does not know the handshake; one that has
// moved answers from elsewhere.
bool Handshakes::goes_on(Time now, One& one, const NetAddress& to, const Retry& retry,
                         bool restarts) {
  const Duration silence = now - one.heard;
  if (one.address != to) return silence < kBelievedAfter;
  if (one.cookie != retry.cookie) return silence < (restarts ? kRestartTime : kBelievedAfter);
  if (silence >= CryptoStream::kRepeatFirst) {
    one.stream.repeat();
    flush(now, one);
  }
  return silence < kSilenceMax;
}

bool Handshakes::accept(Time now, const NetAddress& from, const Crypto& first) {
  if (!make_room(now)) {
    ++counters_.turned_away;
    return false;
  }
  ++counters_.accepted;
  One& one = add(now, Side::kAccepts, from, first.token, first.cookie);
  one.waits_since = now;
  std::ranges::copy(first.bytes.first(std::min(kBeginning, first.bytes.size())),
                    one.beginning.begin());
  give(now, one, first);
  return true;
}

std::size_t Handshakes::accepted_now() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      all_, [](const auto& entry) { return entry.second.side == Side::kAccepts; }));
}

Handshakes::Counters Handshakes::counters() const {
  Counters counters = counters_;
  counters.in_progress = accepted_now();
  return counters;
}

// Only the other side's delays count: one that waits for the handshaker of this side has cost work
// already, which would have to be done again.
bool Handshakes::make_room(Time now) {
  if (accepted_now() < kAcceptedMax) return true;
  const auto yields = [&](const auto& entry) {
    const One& one = entry.second;
    if (one.side != Side::kAccepts || one.is_our_turn()) return false;
    const Duration waited = one.waited + (now - one.waits_since);
    return waited >= (one.answer_sent ? kAnsweredYieldsAfter : kYieldsAfter);
  };
  const auto oldest = std::ranges::find_if(all_, yields);
  if (oldest == all_.end()) return false;
  give_up(oldest->second);
  return true;
}

// It is this side's turn.
void Handshakes::take_turn(Time now, One& one) {
  if (!one.is_our_turn()) one.waited += now - one.waits_since;
  one.waits_since = kNever;
}

// Only the connecting side repeats its cookie. A router that begins again has another one, so what
// is left of its earlier handshake does not hinder it.
Handshakes::One* Handshakes::find(const NetAddress& from, const Crypto& crypto) {
  const auto found = std::ranges::find_if(all_, [&](const auto& entry) {
    const One& one = entry.second;
    const bool connects = one.side == Side::kConnects;
    return one.token == crypto.token && connects == crypto.from_accepting && one.address == from &&
           (connects || one.cookie == crypto.cookie);
  });
  return found == all_.end() ? nullptr : &found->second;
}

std::optional<std::uint64_t> Handshakes::cookie_of(const NetAddress& from,
                                                   std::uint64_t token) const {
  const auto found = std::ranges::find_if(all_, [&](const auto& entry) {
    const One& one = entry.second;
    return one.side == Side::kAccepts && one.token == token && one.address == from;
  });
  return found == all_.end() ? std::nullopt : std::optional(found->second.cookie);
}

Handshakes::One* Handshakes::calling(std::uint64_t token) {
  const auto found = std::ranges::find_if(all_, [&](const auto& entry) {
    return entry.second.side == Side::kConnects && entry.second.token == token;
  });
  return found == all_.end() ? nullptr : &found->second;
}

Handshakes::One* Handshakes::find(std::uint64_t number) {
  const auto found = all_.find(number);
  return found == all_.end() ? nullptr : &found->second;
}

bool Handshakes::on_crypto(Time now, const NetAddress& from, const Crypto& crypto) {
  One* one = find(from, crypto);
  if (one == nullptr) return false;
  if (one->side == Side::kAccepts && crypto.offset == 0) {
    const std::size_t known = std::min(kBeginning, crypto.bytes.size());
    if (!std::ranges::equal(crypto.bytes.first(known), std::span(one->beginning).first(known))) {
      if (one->is_our_turn()) return true;
      give_up(*one);
      return false;
    }
  }
  give(now, *one, crypto);
  return true;
}

void Handshakes::give(Time now, One& one, const Crypto& crypto) {
  std::span<const std::byte> bytes;
  if (!one.stream.receive(crypto, bytes)) return;
  one.heard = now;
  one.behind.insert(one.behind.end(), bytes.begin(), bytes.end());
  pass_on(now, one);
  if (one.answer_sent && one.stream.is_acknowledged()) return end(one.number);
  flush(now, one);
}

// What comes in many small pieces is given to the handshaker in as few as it can take.
void Handshakes::pass_on(Time now, One& one) {
  if (one.is_our_turn() || one.behind.empty()) return;
  take_turn(now, one);
  handshaker_->receive(one.number, std::exchange(one.behind, {}));
}

void Handshakes::on_progress(Time now, HandshakeProgress&& progress) {
  One* one = find(progress.handshake);
  if (one == nullptr) return;
  one->waits_since = now;
  const bool fits = one->stream.write(progress.to_send);
  if (one->answered && !progress.to_send.empty()) one->answer_sent = true;
  flush(now, *one);
  if (!progress.failure.empty() || !fits)
    return fail(now, one->number, fits ? progress.failure : "the handshake is too long");
  if (progress.verified.sealer) one->verified = std::move(progress.verified);
  for (auto& message : progress.messages) {
    one->message = std::move(message);
    observer_.on_message(now, *one);
    one = find(progress.handshake);
    if (one == nullptr) return;
  }
  pass_on(now, *one);
}

void Handshakes::answer(Time now, One& handshake, std::span<const std::byte> message) {
  if (handshake.side == Side::kAccepts && !handshake.answered) ++counters_.answered;
  handshake.answered = true;
  handshake.asks_again = kNever;
  take_turn(now, handshake);
  handshaker_->send(handshake.number, message);
  flush(now, handshake);
}

void Handshakes::finish(Time now, One& handshake) {
  flush(now, handshake);
  end(handshake.number);
}

void Handshakes::flush(Time now, One& one) {
  const bool accepts = one.side == Side::kAccepts;
  const Crypto head{
      .from_accepting = accepts, .token = one.token, .cookie = accepts ? 0 : one.cookie};
  one.stream.flush(now, head, [&](const Crypto& crypto) {
    std::array<std::byte, kDatagramBase> bytes{};
    observer_.send(one.address, std::span(bytes).first(encode(crypto, bytes)));
  });
}

void Handshakes::end(std::uint64_t number) {
  handshaker_->end(number);
  all_.erase(number);
}

void Handshakes::give_up(const One& one) {
  if (one.side == Side::kAccepts && !one.answered) ++counters_.given_up;
  end(one.number);
}

void Handshakes::fail(Time now, std::uint64_t number, std::string_view why) {
  const auto node = all_.extract(number);
  handshaker_->end(number);
  observer_.on_failed(now, node.mapped(), why);
}

// --- time

Time Handshakes::due(const One& one) {
  Time at = std::min({one.began + kTimeMax, one.stream.next_timeout(), one.asks_again});
  if (one.side == Side::kConnects) at = std::min(at, one.heard + kSilenceMax);
  return at;
}

Time Handshakes::next_timeout() const {
  Time next = kNever;
  for (const auto& [number, one] : all_) next = std::min(next, due(one));
  return next;
}

void Handshakes::on_timeout(Time now) {
  std::vector<std::uint64_t> numbers;
  for (const auto& [number, one] : all_)
    if (due(one) <= now) numbers.push_back(number);
  for (const std::uint64_t number : numbers) {
    One* one = find(number);
    if (one == nullptr) continue;
    const bool silent = one->side == Side::kConnects && now >= one->heard + kSilenceMax;
    if (silent || now >= one->began + kTimeMax) {
      give_up(*one);
    } else if (one->asks_again <= now) {
      one->asks_again = kNever;
      observer_.on_message(now, *one);
    } else {
      flush(now, *one);
    }
  }
}

}  // namespace tims::link
