// A router among neighbours that offer, ask for and send lists of the fleet as the input says, come
// and go, and let the time pass. Properties: what is received stays within its bounds, only what is
// newer and complete is verified, nothing is asked for at once again and again, and what has ended
// leaves no deadline behind.
#include <vector>

#include "router/link/list_exchange.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace tims;
using namespace std::chrono_literals;
using link::ListExchange;

class Among : public ListExchange::Carrier {
 public:
  void act(fuzz::Input& in) {
    const auto what = in.number<std::uint8_t>();
    const std::uint32_t slot = what >> 4 & 7;
    sent_ = 0;
    switch (what % 8) {
      case 0:
        exchange_.begin(now_, slot, what >= 0x80);
        break;
      case 1:
        exchange_.end(now_, slot);
        break;
      case 2:
        return pass(1ms * in.number<std::uint16_t>());
      case 3:
        if (!checks_.empty()) {
          exchange_.on_checked(now_, checks_.front(), what >= 0x80);
          checks_.erase(checks_.begin());
        }
        break;
      case 4:
        own(exchange_.number() + what / 64);
        break;
      default:
        message(static_cast<std::int8_t>(link::control::kList + what % 8 - 5), slot, in);
    }
    check();
  }
  // Everybody goes.
  void end() {
    for (std::uint32_t slot = 0; slot < 8; ++slot) exchange_.end(now_, slot);
    for (const std::uint64_t transfer : checks_) exchange_.on_checked(now_, transfer, false);
    fuzz::require(exchange_.transfers() == 0 && exchange_.next_timeout() == kNever);
  }

 private:
  void send_list_message(Time, std::uint32_t, link::ControlMessage& message) override {
    fuzz::require(message.finish().size() <= kHeaderSize + link::ControlMessage::kBodyMax);
    ++sent_;
  }
  [[nodiscard]] std::size_t list_part_size(std::uint32_t slot) const override {
    return slot == 7 ? 0 : 1024 + 1000 * slot;
  }
  void check_list(std::uint64_t transfer, std::uint64_t number, std::uint32_t,
                  std::vector<std::byte>&& bytes) override {
    fuzz::require(number > exchange_.number());
    fuzz::require(!bytes.empty() && bytes.size() <= ListExchange::kBytesMax);
    checks_.push_back(transfer);
  }
  void own(std::uint64_t number) {
    exchange_.set_own(now_, {number, std::make_shared<const std::vector<std::byte>>(5000)});
  }
  // Mostly what is expected: numbers a little above, offsets where a part may begin.
  void message(std::int8_t type, std::uint32_t slot, fuzz::Input& in) {
    const auto low = in.number<std::uint8_t>();
    const auto offset = in.number<std::uint16_t>();
    link::ControlMessage message(type);
    message.put(link::ListPlace{exchange_.number() + low % 8,
                                low % 3 == 0 ? std::uint32_t{offset} << 6 : offset});
    const std::vector<std::byte> bytes(type == link::control::kListPart ? 1024U + low : low % 2);
    message.put(bytes);
    const auto made = message.finish();
    std::vector<std::byte> all(made.begin(), made.end());
    if (low == 0xFF) all.resize(kHeaderSize + offset % (all.size() - kHeaderSize + 1));
    (void)exchange_.on_control(now_, slot, {.header = {.type = type}, .bytes = all});
  }
  void pass(Duration time) {
    const Time end = now_ + time;
    int steps = 0;
    while (exchange_.next_timeout() <= end) {
      now_ = std::max(now_, exchange_.next_timeout());
      exchange_.on_timeout(now_);
      fuzz::require(exchange_.next_timeout() > now_ && ++steps <= 1000);
      check();
    }
    now_ = end;
  }
  void check() const {
    fuzz::require(exchange_.transfers() <= ListExchange::kAtOnce);
    fuzz::require(checks_.size() <= ListExchange::kAtOnce);
    fuzz::require(sent_ <= 8 + 2 * 1000);
  }

  Time now_{100s};
  std::vector<std::uint64_t> checks_;
  std::size_t sent_ = 0;
  ListExchange exchange_{*this};
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  Among among;
  for (int n = 0; n < 500 && !in.empty(); ++n) among.act(in);
  among.end();
  return 0;
}
