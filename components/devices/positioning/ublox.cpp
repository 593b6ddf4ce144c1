#include "components/devices/positioning/ublox.h"

#include <algorithm>

#include "rack/devices/device_clock.h"
#include "rack/devices/pieces.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kListenTime = 1200ms;  // sufficient for messages sent once a second
constexpr Duration kUbloxAnswerTime = 1s;
constexpr Duration kFirstFix = 5s;
constexpr Duration kLeaves = 100ms;  // until a message has left this host
constexpr int kUbloxAttempts = 3;
constexpr int kRateTries = 4;

// The upper four bits of a key determine the size of its value.
void put_value(std::vector<std::byte>& out, std::uint32_t key, std::uint64_t value) {
  append_little(out, key);
  for (std::size_t i = 0; i < ubx_value_size(key); ++i)
    out.push_back(static_cast<std::byte>(value >> (8 * i)));
}

}  // namespace

std::vector<std::uint32_t> Ublox::rates() const {
  std::vector<std::uint32_t> rates;
  for (const std::uint32_t rate : {settings_.baud, 38400U, 9600U, 115200U, 460800U, 57600U})
    if (rate != 0 && std::ranges::find(rates, rate) == rates.end()) rates.push_back(rate);
  return rates;
}

void Ublox::start(Time now, Output& out) {
  clear_failure();
  stream_.clear();
  nmea_.start(now, out);
  is_old_ = has_pvt_ = is_ready_ = has_data_ = false;
  if (settings_.only_listen) {
    state_ = State::kListen;
    is_ready_ = true;
    timer_.reset();
    return;
  }
  rates_ = rates();
  rate_tries_ = 0;
  find_at(0, now, out);
}

// --- the rate of the line

void Ublox::find_at(std::size_t rate, Time now, Output& out) {
  rate_ = rate;
  state_ = State::kFind;
  stream_.clear();
  out.set_baud(rates_[rate]);
  question_.clear();
  append_ubx(question_, ubx::kMon, ubx::kVersion, {});
  out.send(question_);
  timer_.wait_until(now + kListenTime);
}

void Ublox::found(Time now, Output& out) {
  const bool has_rate = settings_.baud == 0 || rates_[rate_] == settings_.baud;
  enter(has_rate ? State::kSetFix : State::kSetRate, now, out);
}

// --- configuration

void Ublox::enter(State state, Time now, Output& out) {
  state_ = state;
  timer_.reset();
  if (state == State::kListen)
    timer_.wait_until(now + std::max(kFirstFix, 3 * settings_.period));
  else
    ask(now, out);
}

void Ublox::ask(Time now, Output& out) {
  question_.clear();
  payload_.clear();
  if (state_ == State::kVerifyRate) {
    append_ubx(question_, ubx::kMon, ubx::kVersion, {});
  } else {
    if (is_old_)
      ask_old(state_);
    else
      ask_values(state_);
    append_ubx(question_, ubx::kCfg, asked_, payload_);
  }
  out.send(question_);
  // The rate of the line may change only after the whole message has been transmitted.
  const bool is_rate = state_ == State::kSetRate;
  timer_.sent(now,
              is_rate ? line_time(question_.size(), rates_[rate_]) + kLeaves : kUbloxAnswerTime);
}

void Ublox::ask_values(State state) {
  asked_ = ubx::kCfgValues;
  append_little(payload_, std::uint8_t{0});
  append_little(payload_, ubx::kLayerRam);
  append_little(payload_, std::uint16_t{0});
  if (state == State::kSetRate) put_value(payload_, ubx::kBaudOfUart1, settings_.baud);
  if (state == State::kSetFix) {
    const auto milliseconds =
        std::chrono::duration_cast<std::chrono::milliseconds>(settings_.period);
    put_value(payload_, ubx::kMillisecondsOfFix, static_cast<std::uint64_t>(milliseconds.count()));
  }
  if (state == State::kSetMessage) {
    put_value(payload_, ubx::kUbxOutOfUart1, 1);
    put_value(payload_, ubx::kPvtAtUart1, 1);
    put_value(payload_, ubx::kPvtAtUsb, 1);
  }
}

void Ublox::ask_old(State state) {
  constexpr std::uint32_t kEightBitsNoParity = 0x8D0;
  constexpr std::uint16_t kInAll = 7;  // UBX, NMEA, RTCM
  constexpr std::uint16_t kOutBoth = 3;
  if (state == State::kSetRate) {
    asked_ = ubx::kCfgPort;
    append_little(payload_, std::uint32_t{1});  // UART 1
    append_little(payload_, kEightBitsNoParity);
    append_little(payload_, settings_.baud);
    append_little(payload_, kInAll);
    append_little(payload_, kOutBoth);
    append_little(payload_, std::uint32_t{0});
  }
  if (state == State::kSetFix) {
    asked_ = ubx::kCfgRate;
    const auto milliseconds =
        std::chrono::duration_cast<std::chrono::milliseconds>(settings_.period);
    append_little(payload_, static_cast<std::uint16_t>(milliseconds.count()));
    append_little(payload_, std::uint16_t{1});  // one solution per measurement
    append_little(payload_, std::uint16_t{0});  // aligned to UTC
  }
  if (state == State::kSetMessage) {
    asked_ = ubx::kCfgMessage;
    for (const std::uint8_t byte : {ubx::kNav, ubx::kPvt, std::uint8_t{1}})
      append_little(payload_, byte);
  }
}

// --- answers

void Ublox::on_arrival(const Arrival& arrival, Output& out) {
  in_pieces(arrival, UbxStream::kPieceMax, [&](const Arrival& piece) {
    stream_.add(piece);
    UbxFrame frame;
    NmeaSentence sentence;
    for (;;) {
      const UbxStream::What what = stream_.next(frame, sentence);
      if (what == UbxStream::What::kNothing) return;
      if (what == UbxStream::What::kFrame) on_frame(frame, out);
      if (what == UbxStream::What::kSentence) {
        nmea_.add(sentence);
        take_nmea();
      }
      if (state_ == State::kFind) found(arrival.last, out);
    }
  });
}

void Ublox::on_frame(const UbxFrame& frame, Output& out) {
  if (frame.is(ubx::kNav, ubx::kPvt)) return take_pvt(frame);
  if (state_ == State::kVerifyRate && frame.is(ubx::kMon, ubx::kVersion))
    return enter(State::kSetFix, frame.began, out);
  const bool waits = state_ >= State::kSetRate && state_ <= State::kSetMessage;
  const bool answers = frame.class_id == ubx::kAck && frame.payload.size() >= 2 &&
                       std::to_integer<std::uint8_t>(frame.payload[0]) == ubx::kCfg &&
                       std::to_integer<std::uint8_t>(frame.payload[1]) == asked_;
  if (waits && answers) on_answer(frame.number == ubx::kAccepted, frame.began, out);
}

void Ublox::on_answer(bool accepted, Time now, Output& out) {
  if (state_ == State::kVerifyRate) return;
  if (state_ == State::kSetRate) {
    if (accepted || ++rate_tries_ >= kRateTries) return;
    is_old_ = !is_old_;
    return enter(State::kSetRate, now, out);
  }
  if (accepted)
    return enter(state_ == State::kSetFix ? State::kSetMessage : State::kListen, now, out);
  if (!is_old_) {
    is_old_ = true;
    return enter(State::kSetFix, now, out);
  }
  if (state_ == State::kSetFix)
    fail(tims::Errc::kSystem, "the receiver refuses periodTime; set a longer period");
  else
    fail(tims::Errc::kSystem,
         "the receiver does not support NAV-PVT (older than the seventh generation); use GpsNmea");
}

void Ublox::on_timeout(Time now, Output& out) {
  if (!timer_.take_due(now)) return;
  if (state_ == State::kListen) {
    if (!is_ready_) fail(tims::Errc::kTimeout, "the receiver was configured, but sends no fixes");
    return;
  }
  if (state_ == State::kFind) {
    if (rate_ + 1 < rates_.size()) return find_at(rate_ + 1, now, out);
    fail(tims::Errc::kTimeout,
         "no receiver answers at 9600, 38400, 57600, 115200 or 460800 baud; check its power");
    return;
  }
  if (state_ == State::kSetRate) {
    out.set_baud(settings_.baud);
    rate_ = 0;  // the requested rate is first in rates()
    stream_.clear();
    return enter(State::kVerifyRate, now, out);
  }
  on_silence(now, out);
}

void Ublox::on_silence(Time now, Output& out) {
  if (timer_.may_repeat(kUbloxAttempts)) return ask(now, out);
  // A receiver that did not change its rate is still at the detected one: try the other message,
  // and repeat both in case one was lost.
  if (state_ == State::kVerifyRate && ++rate_tries_ < kRateTries) {
    is_old_ = !is_old_;
    return find_at(rates_.size() > 1 ? 1 : 0, now, out);
  }
  if (state_ != State::kVerifyRate && !is_old_) {
    is_old_ = true;
    return enter(State::kSetFix, now, out);
  }
  fail(tims::Errc::kTimeout, state_ == State::kVerifyRate
                                 ? "the receiver does not change to " +
                                       std::to_string(settings_.baud) +
                                       " baud; baudrate=0 keeps the current rate"
                                 : "the receiver sends, but does not answer; check the wiring of "
                                   "its input");
}

// --- fixes

void Ublox::take_pvt(const UbxFrame& frame) {
  if (!decode_ubx_pvt(frame.payload, data_, moment_)) return;
  measured_ = frame.began;
  has_data_ = has_pvt_ = true;
  if (state_ == State::kListen) is_ready_ = true;
}

void Ublox::take_nmea() {
  if (has_pvt_ || !nmea_.take(data_, measured_)) return;
  moment_ = nmea_.moment();
  has_data_ = true;
}

bool Ublox::take(GpsData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  taken_ = moment_;
  recorded = recorded_ = measured_;
  return true;
}

}  // namespace rack::device
