#include "router/link/session_keys.h"

#include <algorithm>
#include <utility>

namespace tims::link {
namespace {

// In place of keys. What it seals does not open anywhere, and shows nothing.
class NoKeys final : public Sealer {
 public:
  void seal(std::uint64_t, std::span<const std::byte>, std::span<std::byte> text,
            std::span<std::byte, kTagSize> tag) override {
    std::ranges::fill(text, std::byte{0});
    std::ranges::fill(tag, std::byte{0});
  }
  bool open(Phase, std::uint64_t, std::span<const std::byte>, std::span<std::byte>,
            std::span<const std::byte, kTagSize>) override {
    return false;
  }
  void next_sending_phase() override {}
  void next_receiving_phase() override {}
  [[nodiscard]] std::string_view suite() const override { return "none yet"; }
};

}  // namespace

void SessionKeys::lock(Time now, std::uint8_t generation) {
  begin(now, std::make_unique<NoKeys>());
  current_.number = generation;
  locked_ = true;
}

void SessionKeys::begin(Time now, std::unique_ptr<Sealer> sealer) {
  clear();
  current_ = {.sealer = std::move(sealer), .since = now, .sends_since = now};
}

void SessionKeys::renew(Time now, std::uint8_t generation, std::unique_ptr<Sealer> sealer,
                        bool confirmed) {
  next_ = {.number = generation, .sealer = std::move(sealer), .since = now, .sends_since = now};
  if (confirmed) use_next(now);
}

std::uint8_t SessionKeys::next_generation() const {
  const Generation& newest = next_.sealer ? next_ : current_;
  return static_cast<std::uint8_t>(newest.number + 1);
}

void SessionKeys::use_next(Time now) {
  former_ = std::exchange(current_, std::exchange(next_, {}));
  former_until_ = now + kFormerFor;
  if (std::exchange(locked_, false)) former_ = {};
}

void SessionKeys::seal(Time now, std::uint64_t token, std::uint64_t packet,
                       std::span<std::byte> datagram) {
  Generation& keys = current_;
  if (keys.sealer && (keys.sealed >= kPacketsMax || now >= keys.sends_since + kPhaseMax)) {
    keys.sealer->next_sending_phase();
    ++keys.sending;
    keys.sealed = 0;
    keys.sends_since = now;
  }
  const auto header = datagram.first<kDataHeaderSize>();
  encode({.token = token,
          .packet = static_cast<std::uint32_t>(packet),
          .phase = keys.sending,
          .generation = keys.number},
         header);
  if (!keys.sealer) return;
  ++keys.sealed;
  const std::size_t text = datagram.size() - kDataHeaderSize - Sealer::kTagSize;
  keys.sealer->seal(packet, header, datagram.subspan(kDataHeaderSize, text),
                    datagram.last<Sealer::kTagSize>());
}

SessionKeys::Verdict SessionKeys::open(Time now, std::uint64_t packet, Data& data) {
  if (!are_used()) return Verdict::kOpened;
  const std::uint8_t generation = data.header.generation;
  if (generation == current_.number) return open(now, packet, data, current_);
  if (next_.sealer && generation == next_.number) {
    const Verdict verdict = open(now, packet, data, next_);
    if (verdict == Verdict::kOpened) use_next(now);
    return verdict;
  }
  const bool former = former_.sealer && generation == former_.number && now < former_until_;
  return former ? open(now, packet, data, former_) : Verdict::kOldKey;
}

SessionKeys::Verdict SessionKeys::open(Time now, std::uint64_t packet, Data& data,
                                       Generation& keys) {
  if (data.frames.size() < Sealer::kTagSize) return Verdict::kForged;
  const auto ahead = static_cast<std::uint8_t>(data.header.phase - keys.receiving);
  Sealer::Phase phase = Sealer::Phase::kCurrent;
  if (ahead == 1) {
    phase = Sealer::Phase::kNext;
  } else if (ahead == 0xFF && now < keys.former_until && packet < keys.first) {
    phase = Sealer::Phase::kFormer;
  } else if (ahead != 0) {
    return Verdict::kOldKey;
  }
  const std::size_t size = data.frames.size() - Sealer::kTagSize;
  const auto text = data.frames.first(size);
  if (!keys.sealer->open(phase, packet, data.head, text, data.frames.last<Sealer::kTagSize>()))
    return Verdict::kForged;
  data.frames = text;
  if (phase != Sealer::Phase::kNext) return Verdict::kOpened;
  keys.sealer->next_receiving_phase();
  ++keys.receiving;
  keys.first = packet;
  keys.former_until = now + kFormerFor;
  return Verdict::kOpened;
}

}  // namespace tims::link
