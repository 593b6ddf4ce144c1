// A mailbox whose memory is modified by another program while it is used: no access is outside of
// the memory, and no message is larger than its slot.
#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "shm/layout.h"
#include "shm/receiver.h"
#include "shm/sender.h"
#include "tests/fuzz/fuzz_input.h"
#include "wire/header.h"

namespace {

using namespace tims;
using namespace tims::shm;

constexpr std::uint32_t kSlots = 4;

struct Kind {
  std::uint32_t length_max;
  std::uint32_t long_places;
  std::uint32_t step;  // between lengths
};
// Messages in slots; long bodies in separate places, one per slot; long bodies in shared places.
constexpr std::array<Kind, 3> kKinds{{{48, 0, 1}, {5000, 0, 37}, {5000, 2, 37}}};

struct Free {
  void operator()(std::byte* memory) const { std::free(memory); }
};

class HostileMailbox {
 public:
  explicit HostileMailbox(const Kind& kind)
      : kind_(kind),
        memory_(static_cast<std::byte*>(std::aligned_alloc(kMailboxAlign, bytes()))),
        view_(lay_out(memory_.get())),
        receiver_(view_),
        sender_(view_, 7) {}

  void step(fuzz::Input& input) {
    switch (input.number<std::uint8_t>() % 6) {
      case 0:
        return scribble(input);
      case 1:
        return send(input);
      case 2:
        return take();
      case 3:
        return release();
      case 4:
        fuzz::use(tims::shm::waiting(receiver_.view()));
        fuzz::use(reclaim(receiver_.view(), [](std::uint32_t writer) { return writer % 2 == 1; }));
        return;
      default:
        return reopen();
    }
  }

 private:
  [[nodiscard]] std::size_t bytes() const {
    const std::size_t exact = Geometry::of(kSlots, kind_.length_max, kind_.long_places).bytes;
    return (exact + kMailboxAlign - 1) / kMailboxAlign * kMailboxAlign;
  }
  [[nodiscard]] MailboxView lay_out(std::byte* memory) const {
    std::memset(memory, 0, bytes());
    return MailboxView::create({memory, bytes()}, 0,
                               {.address = Address(0x03140000),
                                .slots = kSlots,
                                .message_max = kind_.length_max,
                                .long_places = kind_.long_places});
  }

  void scribble(fuzz::Input& input) {
    const std::size_t at = input.number<std::uint16_t>() % (bytes() - 7);
    const auto value = input.number<std::uint64_t>();
    std::memcpy(memory_.get() + at, &value, sizeof value);
  }
  void send(fuzz::Input& input) {
    Claim claim;
    const std::uint32_t length =
        kHeaderSize + input.number<std::uint8_t>() * kind_.step % kind_.length_max;
    const auto priority = input.number<std::uint8_t>();
    if (!tims::shm::taken(sender_.claim(length, priority, claim))) return;
    const std::size_t size = length - kHeaderSize;
    fuzz::require(length <= kind_.length_max && inside({claim.header, kHeaderSize}) &&
                  inside({claim.body, size}));
    // Every second message has a correct length.
    const auto fill = input.number<std::uint8_t>();
    std::memset(claim.header, fill, kHeaderSize);
    if (fill % 2 == 0) {
      const Header header{.priority = priority, .length = length};
      wire::encode_header(header, std::span<std::byte, kHeaderSize>(claim.header, kHeaderSize));
    }
    std::memset(claim.body, input.number<std::uint8_t>(), size);
    fuzz::use(sender_.commit(claim));
  }
  void take() {
    const auto message = receiver_.take();
    if (!message) return;
    fuzz::require(message->body.size() + kHeaderSize <= kind_.length_max && inside(message->body));
    held_.push_back(*message);
  }
  void release() {
    if (held_.empty()) return;
    receiver_.release(held_.back().hint);
    held_.pop_back();
  }
  void reopen() const {
    const auto again = MailboxView::open({memory_.get(), bytes()}, 0);
    if (!again) return;
    const Geometry& g = again->geometry();
    fuzz::require(g.bytes <= bytes());
    fuzz::require(inside({again->message_header(g.slots - 1), kHeaderSize + g.short_max}));
    if (g.long_places > 0)
      fuzz::require(inside({again->long_body(g.long_places - 1), g.message_max - kHeaderSize}));
  }
  [[nodiscard]] bool inside(std::span<const std::byte> part) const {
    return part.data() >= memory_.get() && part.data() + part.size() <= memory_.get() + bytes();
  }

  Kind kind_;
  std::unique_ptr<std::byte, Free> memory_;
  MailboxView view_;
  Receiver receiver_;
  Sender sender_;
  std::vector<Taken> held_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  HostileMailbox mailbox(kKinds[input.number<std::uint8_t>() % kKinds.size()]);
  while (!input.empty()) mailbox.step(input);
  return 0;
}
