#include "components/devices/scanners/ibeo_emulator.h"

#include <cmath>
#include <numbers>

namespace rack::device::emulator {
namespace {

using namespace std::chrono_literals;

constexpr Duration kTurnTime = 100ms;
constexpr int kIbeoEmulatorStep = 8;  // half a degree
constexpr int kIbeoEmulatorFirst = -120;
constexpr int kMiddle = 0;
constexpr int kIbeoEmulatorLast = 120;
constexpr double kIbeoEmulatorRange = 200;  // m

// Time at which the beam has an angle, since it pointed backwards.
Duration time_at(double degrees) {
  return std::chrono::duration_cast<Duration>(kTurnTime * ((degrees + 180) / 360));
}

}  // namespace

void Ibeo::start(Time now, Output&) {
  telegrams_ = IbeoTelegrams(settings_.sensor);
  mode_ = settings_.is_broken ? ibeo::kModeError : ibeo::kModeIdle;
  zero_ = now - 50s;
  next_ = tims::kNever;
}

void Ibeo::on_arrival(const Arrival& arrival, Output& out) {
  if (arrival.id != ibeo::kHostId) return;
  IbeoTelegram telegram;
  if (telegrams_.take(arrival, telegram)) obey(telegram, arrival.last, out);
}

void Ibeo::append(unsigned number) {
  data_.push_back(static_cast<std::byte>(number >> 8));
  data_.push_back(static_cast<std::byte>(number));
}

void Ibeo::append_status(Time now) {
  const bool measures = mode_ == ibeo::kModeMeasuring && now >= measures_since_;
  const unsigned mode = mode_ == ibeo::kModeMeasuring && !measures ? ibeo::kModeTurning : mode_;
  append(0);
  append(mode);
}

void Ibeo::answer(std::uint16_t service, Output& out) {
  frames_.clear();
  append_ibeo(frames_, ibeo::kHost, service | ibeo::kAnswer, data_);
  for (const IbeoFrame& frame : frames_) out.send(frame, ibeo::kSensorId | settings_.sensor);
}

unsigned Ibeo::counter(Time time) const {
  return static_cast<unsigned>(
             std::chrono::duration_cast<std::chrono::milliseconds>(time - zero_).count()) &
         0xFFFF;
}

void Ibeo::obey(const IbeoTelegram& telegram, Time now, Output& out) {
  data_.clear();
  const bool is_broken = mode_ == ibeo::kModeError;
  switch (telegram.service) {
    case ibeo::kStatus:
      append_status(now);
      break;
    case ibeo::kSetTime:
      zero_ = now;
      append(0);
      break;
    case ibeo::kNoProfiles:
      next_ = tims::kNever;
      append_status(now);
      break;
    case ibeo::kIdle:
    case ibeo::kTurn:
      if (!is_broken)
        mode_ = telegram.service == ibeo::kIdle ? ibeo::kModeIdle : ibeo::kModeTurning;
      append_status(now);
      break;
    case ibeo::kMeasure:
      if (!is_broken && settings_.measure_error == 0) {
        mode_ = ibeo::kModeMeasuring;
        measures_since_ = now + settings_.spin_up;
      }
      append_status(now);
      append(settings_.measure_error);
      break;
    case ibeo::kProfiles:
      if (telegram.parameters.size() < 4) return;
      format_ = big_endian<std::uint16_t>(telegram.parameters, 2);
      next_ = now + kTurnTime;
      return;
    default:
      return;
  }
  answer(telegram.service, out);
}

void Ibeo::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  const Time begin = next_ - time_at(kIbeoEmulatorLast);
  data_.clear();
  append(format_);
  append(1 << 8 | 2);  // layers, sectors
  append_sector(kIbeoEmulatorFirst, kMiddle, begin);
  append_sector(kMiddle, kIbeoEmulatorLast, begin);
  append_status(now);
  answer(ibeo::kProfiles, out);
  next_ += kTurnTime;
}

void Ibeo::append_sector(int from, int to, Time begin) {
  constexpr int kSixteenths = 16;
  const int points = (to - from) * kSixteenths / kIbeoEmulatorStep;
  append(kIbeoEmulatorStep);
  append(static_cast<unsigned>(points));
  append(counter(begin + time_at(from)));
  append(static_cast<unsigned>((from + 180) * kSixteenths));
  for (int i = 0; i < points; ++i) {
    const double degrees = from + static_cast<double>(i) * kIbeoEmulatorStep / kSixteenths;
    const double metres =
        settings_.sight(degrees * std::numbers::pi / 180, 0, begin + time_at(degrees)) / 1000;
    append(metres < kIbeoEmulatorRange ? static_cast<unsigned>(std::lround(metres * 256)) : 0);
  }
  append(counter(begin + time_at(to)));
}

}  // namespace rack::device::emulator
