#include "components/devices/positioning/ublox_emulator.h"

#include "components/devices/positioning/nmea_emulator.h"
#include "rack/devices/pieces.h"

namespace rack::device::emulator {
namespace {

constexpr std::size_t kPvtSize = 92;
constexpr int kFirstWithValues = 9;  // generation

template <typename Number>
void set(std::span<std::byte> payload, std::size_t at, Number number) {
  for (std::size_t i = 0; i < sizeof(Number); ++i)
    payload[at + i] = static_cast<std::byte>(number >> (8 * i));
}

std::int32_t rounded(double value) { return static_cast<std::int32_t>(std::lround(value)); }

}  // namespace

void append_pvt(std::vector<std::byte>& out, const CoursePoint& point) {
  std::array<std::byte, kPvtSize> payload{};
  const auto day =
      std::chrono::floor<std::chrono::days>(std::chrono::sys_time<Duration>(point.utc));
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss time(std::chrono::sys_time<Duration>(point.utc) - day);
  set(payload, 4, static_cast<std::uint16_t>(static_cast<int>(date.year())));
  payload[6] = static_cast<std::byte>(static_cast<unsigned>(date.month()));
  payload[7] = static_cast<std::byte>(static_cast<unsigned>(date.day()));
  payload[8] = static_cast<std::byte>(time.hours().count());
  payload[9] = static_cast<std::byte>(time.minutes().count());
  payload[10] = static_cast<std::byte>(time.seconds().count());
  payload[11] = std::byte{7};  // date and time are known
  set(payload, 16, static_cast<std::int32_t>(time.subseconds().count()));
  payload[20] = point.is_fixed ? std::byte{3} : std::byte{0};
  payload[21] = point.is_fixed ? std::byte{1} : std::byte{0};
  payload[23] = static_cast<std::byte>(point.satellites);
  set(payload, 24, rounded(point.longitude * 1e7));
  set(payload, 28, rounded(point.latitude * 1e7));
  set(payload, 32, rounded((point.altitude + 46) * 1000));
  set(payload, 36, rounded(point.altitude * 1000));
  set(payload, 40, std::uint32_t{1100});
  set(payload, 44, std::uint32_t{2400});
  set(payload, 60, rounded(point.speed * 1000));
  set(payload, 64, rounded(point.course * 1e5));
  set(payload, 72, std::uint32_t{150000});
  set(payload, 76, std::uint16_t{160});
  append_ubx(out, ubx::kNav, ubx::kPvt, payload);
}

void UbloxEmulator::start(Time now, Output& out) {
  stream_.clear();
  began_ = next_ = now;
  period_ = std::chrono::seconds(1);
  sends_pvt_ = false;
  baud_ = settings_.baud;
  next_baud_ = 0;
  out.set_baud(baud_);
}

void UbloxEmulator::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  const CoursePoint point = settings_.course(next_, next_ - began_);
  burst_.clear();
  if (sends_pvt_) append_pvt(burst_, point);
  append_sentences(burst_, point, "GN");
  out.send(burst_);
  next_ += period_;
}

void UbloxEmulator::on_arrival(const Arrival& arrival, Output& out) {
  in_pieces(arrival, UbxStream::kPieceMax, [&](const Arrival& piece) {
    stream_.add(piece);
    UbxFrame frame;
    NmeaSentence sentence;
    for (auto what = stream_.next(frame, sentence); what != UbxStream::What::kNothing;
         what = stream_.next(frame, sentence))
      if (what == UbxStream::What::kFrame) on_frame(frame, out);
  });
}

void UbloxEmulator::on_frame(const UbxFrame& frame, Output& out) {
  burst_.clear();
  if (frame.is(ubx::kMon, ubx::kVersion)) {
    const std::array<std::byte, 40> version{};
    append_ubx(burst_, ubx::kMon, ubx::kVersion, version);
    out.send(burst_);
    return;
  }
  if (frame.class_id != ubx::kCfg) return;
  const bool has_values = settings_.generation >= kFirstWithValues;
  const bool good = frame.number == ubx::kCfgValues ? has_values && set_values(frame.payload)
                                                    : !has_values && set_old(frame);
  const std::array about = {static_cast<std::byte>(frame.class_id),
                            static_cast<std::byte>(frame.number)};
  append_ubx(burst_, ubx::kAck, good ? ubx::kAccepted : ubx::kRefused, about);
  out.send(burst_);
  if (next_baud_ == 0) return;
  baud_ = std::exchange(next_baud_, 0);
  out.set_baud(baud_);
}

bool UbloxEmulator::set_values(std::span<const std::byte> payload) {
  std::size_t at = 4;
  while (at + 4 < payload.size()) {
    const auto key = little_endian<std::uint32_t>(payload, at);
    const std::size_t size = ubx_value_size(key);
    at += 4;
    if (size == 0 || at + size > payload.size()) return false;
    std::uint64_t value = 0;
    for (std::size_t i = size; i-- > 0;)
      value = value << 8 | std::to_integer<std::uint64_t>(payload[at + i]);
    if (!set_value(key, value)) return false;
    at += size;
  }
  return at == payload.size();
}

bool UbloxEmulator::set_value(std::uint32_t key, std::uint64_t value) {
  switch (key) {
    case ubx::kBaudOfUart1:
      next_baud_ = static_cast<std::uint32_t>(value);
      return true;
    case ubx::kMillisecondsOfFix:
      if (value < 25) return false;
      period_ = std::chrono::milliseconds(value);
      return true;
    case ubx::kPvtAtUart1:
      sends_pvt_ = value != 0;
      return true;
    default:
      return key == ubx::kUbxOutOfUart1 || key == ubx::kPvtAtUsb;
  }
}

bool UbloxEmulator::set_old(const UbxFrame& frame) {
  const auto& payload = frame.payload;
  if (frame.number == ubx::kCfgPort && payload.size() == 20) {
    next_baud_ = little_endian<std::uint32_t>(payload, 8);
    return true;
  }
  if (frame.number == ubx::kCfgRate && payload.size() == 6) {
    period_ = std::chrono::milliseconds(little_endian<std::uint16_t>(payload));
    return period_ >= std::chrono::milliseconds(50);
  }
  const bool is_pvt = frame.number == ubx::kCfgMessage && payload.size() == 3 &&
                      payload[0] == std::byte{ubx::kNav} && payload[1] == std::byte{ubx::kPvt};
  if (is_pvt) sends_pvt_ = payload[2] != std::byte{0};
  return is_pvt;
}

}  // namespace rack::device::emulator
