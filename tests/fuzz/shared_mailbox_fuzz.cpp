// A mailbox whose memory somebody else scribbles into while it is used: whatever is written there,
// nobody reads or writes outside of it, and no message is larger than a slot.
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "shm/receiver.h"
#include "shm/sender.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace tims;
using namespace tims::shm;

constexpr std::uint32_t kSlots = 4;
constexpr std::uint32_t kLengthMax = 48;

struct Free {
  void operator()(std::byte* memory) const { std::free(memory); }
};

class HostileMailbox {
 public:
  HostileMailbox()
      : memory_(static_cast<std::byte*>(std::aligned_alloc(kMailboxAlign, bytes()))),
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
        return;
      default:
        return reopen();
    }
  }

 private:
  static std::size_t bytes() {
    const std::size_t exact = Geometry::of(kSlots, kLengthMax).bytes;
    return (exact + kMailboxAlign - 1) / kMailboxAlign * kMailboxAlign;
  }
  static MailboxView lay_out(std::byte* memory) {
    std::memset(memory, 0, bytes());
    return MailboxView::create(
        {memory, bytes()}, 0,
        {.address = Address(0x03140000), .slots = kSlots, .message_max = kLengthMax});
  }

  void scribble(fuzz::Input& input) {
    const std::size_t at = input.number<std::uint16_t>() % (bytes() - 7);
    const auto value = input.number<std::uint64_t>();
    std::memcpy(memory_.get() + at, &value, sizeof value);
  }
  void send(fuzz::Input& input) {
    Claim claim;
    const std::uint32_t length = kHeaderSize + input.number<std::uint8_t>() % kLengthMax;
    const auto priority = input.number<std::uint8_t>();
    if (!tims::shm::taken(sender_.claim(length, priority, claim))) return;
    const std::size_t size = length - kHeaderSize;
    fuzz::require(length <= kLengthMax && inside({claim.header, kHeaderSize}) &&
                  inside({claim.body, size}));
    std::memset(claim.header, input.number<std::uint8_t>(), kHeaderSize);
    std::memset(claim.body, input.number<std::uint8_t>(), size);
    fuzz::use(sender_.commit(claim));
  }
  void take() {
    const auto message = receiver_.take();
    if (!message) return;
    fuzz::require(message->body.size() + kHeaderSize <= kLengthMax && inside(message->body));
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

  std::unique_ptr<std::byte, Free> memory_;
  MailboxView view_;
  Receiver receiver_;
  Sender sender_;
  std::vector<Taken> held_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  HostileMailbox mailbox;
  while (!input.empty()) mailbox.step(input);
  return 0;
}
