// A CAN bus behind an SLCAN adapter (core/slcan.h): "serial:/dev/ttyACM0?can=500000".
#include "components/devices/core/slcan.h"
#include "components/devices/io/transports.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr char kEnd = '\r';
constexpr char kNo = '\a';
constexpr std::size_t kLineMax = 64;

class SlcanAdapter final : public Transport {
 public:
  SlcanAdapter(std::unique_ptr<Transport> line, std::uint32_t bit_rate)
      : line_(std::move(line)), description_("CAN behind " + line_->description()) {
    description_ += " with " + std::to_string(bit_rate) + " bit/s";
    coming_.reserve(2 * kLineMax);
    going_.reserve(kLineMax);
  }

  [[nodiscard]] int descriptor() const override { return line_->descriptor(); }
  [[nodiscard]] Time next_timeout() const override { return line_->next_timeout(); }
  [[nodiscard]] std::string description() const override { return description_; }
  [[nodiscard]] std::string statistics() const override {
    return refused_ == 0 ? "" : std::to_string(refused_) + " refused by the adapter";
  }

  Result<void> receive(Time now, const Receive& receive) override {
    return line_->receive(now, [&](const Arrival& arrival) {
      for (const std::byte byte : arrival.bytes)
        take(std::to_integer<char>(byte), arrival, receive);
    });
  }

  Result<bool> send(Time now, std::span<const std::byte> bytes, std::uint32_t id) override {
    going_.clear();
    slcan::append(going_, id, bytes);
    return line_->send(now, std::as_bytes(std::span(going_)), 0);
  }
  // Lines of text. The crashed program may have written an incomplete line: it is terminated first,
  // and the adapter refuses it.
  [[nodiscard]] std::vector<std::vector<std::byte>> to_write(
      const std::vector<Telegram>& telegrams) const override {
    std::vector<std::vector<std::byte>> pieces;
    for (const Telegram& telegram : telegrams) {
      std::string text;
      if (pieces.empty()) text += kEnd;
      slcan::append(text, telegram.id, telegram.bytes);
      const auto bytes = std::as_bytes(std::span(text));
      pieces.emplace_back(bytes.begin(), bytes.end());
    }
    return pieces;
  }

 private:
  void take(char character, const Arrival& arrival, const Receive& receive) {
    if (character == kNo) ++refused_;
    if (character != kEnd && character != kNo) {
      if (coming_.size() < kLineMax) coming_ += character;
      return;
    }
    // The answer to a sent frame may precede a received frame on one line: "zt1230".
    const std::size_t begin = coming_.find_first_of("tTrR");
    if (begin != std::string::npos) {
      if (const auto frame = slcan::parse(std::string_view(coming_).substr(begin)))
        receive(
            {.bytes = frame->view(), .first = arrival.last, .last = arrival.last, .id = frame->id});
    }
    coming_.clear();
  }

  std::unique_ptr<Transport> line_;
  std::string description_;
  std::string coming_;
  std::string going_;
  std::uint64_t refused_ = 0;
};

}  // namespace

Result<std::unique_ptr<Transport>> open_slcan(std::unique_ptr<Transport> line,
                                              std::uint32_t bit_rate) {
  const auto opening = slcan::opening(bit_rate);
  if (!opening)
    return Error(Errc::kInvalidArgument, "can=" + std::to_string(bit_rate) +
                                             ": valid are 10000, 20000, 50000, 100000, 125000, "
                                             "250000, 500000, 800000 and 1000000 bit/s");
  if (auto sent = line->send(Time{}, std::as_bytes(std::span(*opening)), 0); !sent)
    return sent.error();
  return slcan_frames(std::move(line), bit_rate);
}

std::unique_ptr<Transport> slcan_frames(std::unique_ptr<Transport> line, std::uint32_t bit_rate) {
  return std::make_unique<SlcanAdapter>(std::move(line), bit_rate);
}

}  // namespace rack::device
