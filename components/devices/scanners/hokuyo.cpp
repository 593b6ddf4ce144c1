#include "components/devices/scanners/hokuyo.h"

#include <utility>

#include "base/text.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr int kHokuyoAttempts = 2;
constexpr int kAttemptsWhenKnown = 4;
constexpr Duration kHokuyoAnswerTime = 200ms;
// Timeout of an answer with a scan: at 19200 baud, a whole scan takes 1.5 s.
constexpr Duration kMeasureTime = 2s;
// The motor may have to start first.
constexpr Duration kHokuyoSpinUp = 5s;
constexpr std::uint64_t kTimeStampEnd = 1ULL << 24;
// The supported baud rates; the first is that after power-on.
constexpr std::array<std::uint32_t, 7> kHokuyoRates = {19200,  115200, 57600, 38400,
                                                       250000, 500000, 750000};

void append_decimal(std::string& out, std::uint32_t number, std::size_t digits) {
  const std::string text = std::to_string(number);
  if (text.size() < digits) out.append(digits - text.size(), '0');
  out += text;
}

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

}  // namespace

Hokuyo::Hokuyo(const HokuyoSettings& settings) : settings_(settings), clock_(1ms, kTimeStampEnd) {
  scans_.set_start_angle(settings.start_angle);
  reserve_all(scan_);
  constexpr std::size_t kLongest = 64;
  question_.reserve(kLongest);
}

void Hokuyo::start(Time now, Output& out) {
  clear_failure();
  answers_.clear();
  clock_.reset();
  has_scan_ = has_measured_ = switched_ = is_scip1_ = false;
  serial_number_.clear();
  parameters_ = {};
  scans_.set_parameters(parameters_);
  if (settings_.only_listen) {
    state_ = State::kMeasuring;
    timer_.reset();
    return;
  }
  rate_index_ = 0;
  rate_ = settings_.baud;
  out.set_baud(rate_);
  enter(State::kStop, now, out);
}

// Turns the laser off and restores the rate of power-on, so that the next program finds the
// scanner.
void Hokuyo::stop(Time, Output& out) {
  if (settings_.only_listen || state_ < State::kVersion) return;
  if (!is_scip1_) out.send(bytes_of("QT\n"));
  if (!settings_.has_rate || rate_found_ == rate_) return;
  question_ = is_scip1_ ? "S" : "SS";
  append_decimal(question_, kHokuyoRates[0], 6);
  question_ += is_scip1_ ? "5555555\n" : "\n";
  out.send(bytes_of(question_));
}

void Hokuyo::enter(State state, Time now, Output& out) {
  state_ = state;
  timer_.reset();
  ask(now, out);
}

std::string Hokuyo::question() const {
  std::string text;
  switch (state_) {
    case State::kStop:
      return "QT";
    case State::kSwitch:
      return "SCIP2.0";
    case State::kVersion:
      return "VV";
    case State::kParameters:
      return "PP";
    case State::kRate:
      // The seven fives of SCIP 1 have no meaning, but are required.
      text = is_scip1_ ? "S" : "SS";
      append_decimal(text, settings_.baud, 6);
      return is_scip1_ ? text + "5555555" : text;
    case State::kStart:
    case State::kMeasuring:
      text = is_scip1_ ? "G" : settings_.intensities ? "ME" : "MD";
      append_decimal(text, static_cast<std::uint32_t>(settings_.start), is_scip1_ ? 3 : 4);
      append_decimal(text, static_cast<std::uint32_t>(settings_.end), is_scip1_ ? 3 : 4);
      append_decimal(text, static_cast<std::uint32_t>(settings_.cluster), 2);
      // Every scan, without limit.
      return is_scip1_ ? text : text + "000";
  }
  return text;
}

void Hokuyo::ask(Time now, Output& out) {
  // The request of the previous scan is reused if it is the same.
  const bool is_same =
      state_ == State::kMeasuring && is_scip1_ && !question_.empty() && question_[0] == 'G';
  if (!is_same) question_ = question() + "\n";
  out.send(bytes_of(question_));
  const bool measures = state_ >= State::kStart;
  const Duration on_line = rate_ == 0 ? Duration(0) : line_time(question_.size(), rate_);
  timer_.sent(now, on_line + (measures ? kMeasureTime : kHokuyoAnswerTime));
}

void Hokuyo::on_timeout(Time now, Output& out) {
  if (timer_.take_due(now)) retry(now, out);
}

void Hokuyo::retry(Time now, Output& out) {
  // While scans are expected, requests are not repeated.
  const bool waits = state_ == State::kMeasuring && !is_scip1_;
  const int allowed = state_ == State::kStop ? kHokuyoAttempts : kAttemptsWhenKnown;
  if (timer_.may_repeat(allowed) && !waits) return ask(now, out);
  if (state_ == State::kStop && !switched_) return try_next_rate(now, out);
  fail(tims::Errc::kTimeout,
       waits
           ? std::string("the scanner sends no scans; check that its motor turns")
           : "the scanner has stopped answering, at request " + tims::base::in_quotes(question()));
}

void Hokuyo::try_next_rate(Time now, Output& out) {
  while (settings_.has_rate && rate_index_ < kHokuyoRates.size()) {
    const std::uint32_t rate = kHokuyoRates[rate_index_++];
    if (rate == settings_.baud) continue;
    rate_ = rate;
    out.set_baud(rate_);
    answers_.clear();
    enter(State::kStop, now, out);
    return;
  }
  fail(tims::Errc::kTimeout,
       settings_.has_rate ? "no scanner answers, neither at " + std::to_string(settings_.baud) +
                                " baud nor at another rate of SCIP; check its power"
                          : "no scanner answers; check that no other program is connected to it");
}

void Hokuyo::on_arrival(const Arrival& arrival, Output& out) {
  answers_.add(arrival);
  ScipAnswer answer;
  while (answers_.next(answer)) {
    take_answer(answer, arrival.last, out);
    if (failure()) return;
  }
}

void Hokuyo::take_answer(const ScipAnswer& answer, Time now, Output& out) {
  if (answer.question == "PP" && parse_scip_parameters(answer, parameters_))
    scans_.set_parameters(parameters_);
  if (state_ == State::kMeasuring) {
    take_scan(answer, now, out);
    return;
  }
  // Discards scans still in transit after the stop, and late answers.
  const std::string_view asked(question_.data(), question_.size() - 1);
  if (answer.question != asked) return;
  switch (state_) {
    case State::kStop:
      on_stopped(answer, now, out);
      break;
    case State::kSwitch:
      // The status is ignored: the format of the next answer shows which SCIP version is active.
      switched_ = true;
      enter(State::kStop, now, out);
      break;
    case State::kVersion:
      serial_number_ = scip_field(answer, "SERI");
      if (is_wanted("scanner", serial_number_, settings_.serial_number))
        enter(State::kParameters, now, out);
      break;
    case State::kParameters:
      enter(settings_.has_rate && rate_ != settings_.baud ? State::kRate : State::kStart, now, out);
      break;
    case State::kRate:
      on_rate(answer, now, out);
      break;
    case State::kStart:
      on_started(answer, now, out);
      break;
    case State::kMeasuring:
      break;
  }
}

void Hokuyo::on_stopped(const ScipAnswer& answer, Time now, Output& out) {
  rate_found_ = rate_;
  is_scip1_ = !answer.has_sums();
  if (is_scip1_ && !switched_) {
    enter(State::kSwitch, now, out);
  } else if (is_scip1_) {
    if (is_wanted("scanner", serial_number_, settings_.serial_number))
      enter(settings_.has_rate && rate_ != settings_.baud ? State::kRate : State::kStart, now, out);
  } else if (answer.status == "0E") {
    // The scanner is still in the time adjustment mode of a previous program; TM2 ends it.
    out.send(bytes_of("TM2\n"));
    timer_.wait_until(now + kHokuyoAnswerTime);
  } else {
    enter(State::kVersion, now, out);
  }
}

void Hokuyo::on_rate(const ScipAnswer& answer, Time now, Output& out) {
  const bool is_set = answer.status == "00" || answer.status == "0";
  // 03: the rate is already set; 04: there is no rate, for example on USB.
  if (!is_set && answer.status != "03" && answer.status != "04") {
    fail(tims::Errc::kInvalidArgument, "the scanner refuses " + std::to_string(settings_.baud) +
                                           " baud (status " + std::string(answer.status) + ")");
    return;
  }
  if (answer.status != "04") {
    rate_ = settings_.baud;
    out.set_baud(rate_);
  }
  enter(State::kStart, now, out);
}

void Hokuyo::on_started(const ScipAnswer& answer, Time now, Output& out) {
  if (!is_scip1_ && answer.status != "00") {
    refuse(answer);
    return;
  }
  if (is_scip1_ && answer.status != "0") {
    refuse(answer);
    return;
  }
  state_ = State::kMeasuring;
  timer_.reset();
  timer_.wait_until(now + kHokuyoSpinUp);
  if (is_scip1_) take_scan(answer, now, out);
}

void Hokuyo::refuse(const ScipAnswer& answer) {
  std::string why = "the scanner refuses " + tims::base::in_quotes(answer.question) + ", status " +
                    std::string(answer.status);
  if (answer.status >= "01" && answer.status <= "07")
    why += ": start and end must be between " + std::to_string(parameters_.first) + " and " +
           std::to_string(parameters_.last);
  else if (answer.status >= "50" && answer.status <= "97")
    why += ": failure of the laser or the motor";
  fail(tims::Errc::kInvalidArgument, std::move(why));
}

void Hokuyo::take_scan(const ScipAnswer& answer, Time now, Output& out) {
  const auto range = scip_range(answer.question);
  if (!range) return;
  if (!settings_.only_listen) {
    const auto asked = scip_range(std::string_view(question_).substr(0, question_.size() - 1));
    if (range != asked) return;
    if (answer.has_sums() && answer.status >= "50" && answer.status <= "97") {
      refuse(answer);
      return;
    }
  }
  std::uint32_t counter = 0;
  const bool is_scan = scans_.decode(answer, scan_, counter);
  if (is_scan) {
    has_scan_ = has_measured_ = true;
    timer_.reset();
    // The scanner sends after it has measured the last step.
    const Time end = answer.has_sums() ? clock_.to_host(counter, answer.began) : answer.began;
    recorded_ = end - std::chrono::milliseconds(scan_.duration) / 2;
  } else if (answer.status != "00") {
    ++broken_;
  }
  if (is_scip1_) ask(now, out);
}

bool Hokuyo::take(LadarData& scan, Time& recorded) {
  if (!std::exchange(has_scan_, false)) return false;
  std::swap(scan, scan_);
  recorded = recorded_;
  return true;
}

}  // namespace rack::device
