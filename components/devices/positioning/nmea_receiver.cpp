#include "components/devices/positioning/nmea_receiver.h"

#include <algorithm>

#include "components/devices/core/pieces.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

// Includes the start-up time of a receiver.
constexpr Duration kNmeaPatience = 5s;
constexpr int kOftenEnough = 4;

}  // namespace

void NmeaReceiver::start(Time now, Output&) {
  clear_failure();
  lines_.clear();
  fix_.reset();
  instead_.reset();
  since_end_ = {};
  has_begun_ = start_comes_ = is_ready_ = has_data_ = false;
  bytes_ = 0;
  timer_.reset();
  if (!settings_.only_listen)
    timer_.wait_until(now + std::max(kNmeaPatience, (kOftenEnough + 2) * settings_.period));
}

void NmeaReceiver::on_arrival(const Arrival& arrival, Output&) {
  bytes_ += arrival.bytes.size();
  in_pieces(arrival, NmeaLines::kPieceMax, [this](const Arrival& piece) {
    lines_.add(piece);
    NmeaSentence sentence;
    while (lines_.next(sentence)) add(sentence);
  });
}

// There is no data set yet: fails with the probable reason.
void NmeaReceiver::on_timeout(Time now, Output&) {
  if (!timer_.take_due(now)) return;
  const std::string at = std::to_string(settings_.baud) + " baud";
  if (bytes_ == 0)
    fail(tims::Errc::kTimeout, "the receiver sends nothing; check its power and the serial line");
  else if (lines_.sentences() == 0)
    fail(tims::Errc::kTimeout, "received data are not NMEA at " + at +
                                   "; set baudrate, mostly 4800, 9600, 38400 or 115200");
  else
    fail(tims::Errc::kTimeout,
         "the receiver sends no position; configure it to send RMC, GGA, GNS or GLL");
}

void NmeaReceiver::add(const NmeaSentence& sentence) {
  const NmeaKind kind = nmea_kind(sentence);
  if (kind == NmeaKind::kOther) return;
  fix_.add(kind, sentence);
  if (kind == settings_.start) start_comes_ = true;
  if (kind == settings_.end && std::exchange(start_comes_, false)) instead_.reset();
  const NmeaKind start = instead_.value_or(settings_.start);
  const NmeaKind end = instead_.value_or(settings_.end);
  if (kind == start && !has_begun_) {
    has_begun_ = true;
    // The first sentence of a round is closest to the time of measurement.
    begun_ = start == end && fix_.round_began() != Time{} ? fix_.round_began() : sentence.began;
  }
  if (kind == end && has_begun_)
    publish();
  else if (reports_position(kind))
    count_position(kind, sentence.began);
}

void NmeaReceiver::count_position(NmeaKind kind, Time began) {
  if (++since_end_[static_cast<std::size_t>(kind)] < kOftenEnough) return;
  instead_ = kind;
  begun_ = began;
  publish();
}

void NmeaReceiver::publish() {
  since_end_ = {};
  has_begun_ = false;
  fix_.fill(data_);
  moment_ = fix_.moment();
  fix_.end_round();
  recorded_ = begun_;
  has_data_ = is_ready_ = true;
  timer_.stop();
}

bool NmeaReceiver::take(GpsData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  recorded = recorded_;
  taken_ = moment_;
  return true;
}

}  // namespace rack::device
