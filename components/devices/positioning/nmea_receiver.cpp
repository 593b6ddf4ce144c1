#include "components/devices/positioning/nmea_receiver.h"

#include <algorithm>

#include "rack/devices/pieces.h"

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
  binary_ = {};
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
  if (lines_.sentences() == 0) binary_.add(arrival.bytes);
  in_pieces(arrival, NmeaLines::kPieceMax, [this](const Arrival& piece) {
    lines_.add(piece);
    NmeaSentence sentence;
    while (lines_.next(sentence)) add(sentence);
  });
}

// There is no data set yet: fails with the probable reason.
void NmeaReceiver::on_timeout(Time now, Output&) {
  if (timer_.take_due(now)) fail(tims::Errc::kTimeout, why_silent());
}

std::string NmeaReceiver::why_silent() const {
  if (bytes_ == 0) return "the receiver sends nothing; check its power and the serial line";
  if (lines_.sentences() == 0) return why_no_sentence();
  return "the receiver sends no position; configure it to send RMC, GGA, GNS or GLL";
}

std::string NmeaReceiver::why_no_sentence() const {
  if (const std::string_view binary = binary_.found(); !binary.empty())
    return "the receiver sends " + std::string(binary);
  if (lines_.without_checksum() > 0)
    return "the receiver sends NMEA without checksums, with which errors of the line cannot be "
           "recognised; configure it to send them (*hh at the end of each sentence)";
  if (lines_.broken() > 0)
    return "all " + std::to_string(lines_.broken()) +
           " sentences of NMEA have wrong checksums; check the serial line for interference and "
           "other writers";
  return "received data are not NMEA at " + std::to_string(settings_.baud) +
         " baud; set baudrate, mostly 4800, 9600, 38400 or 115200";
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
