#include "components/devices/scanners/sick_cola.h"

#include <algorithm>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kSickColaAnswerTime = 1s;
constexpr Duration kAnswerTimeToIdentify = 500ms;
constexpr Duration kSpinUpTime = 20s;
constexpr int kSickColaAttempts = 3;
constexpr int kAttemptsToIdentify = 6;  // in both dialects alternately
constexpr Duration kTick = 1us;         // unit of the scanner's counter
constexpr std::uint64_t kTurnOfCounter = std::uint64_t{1} << 32;

// Default passwords of the authorised client: of most scanners, and of the safety TiM.
constexpr std::array<std::uint32_t, 2> kPasswords = {0xF4724744, 0x6FD62C05};
constexpr std::uint8_t kAuthorisedClient = 3;

}  // namespace

SickCola::SickCola(const SickColaSettings& settings)
    : settings_(settings),
      dialect_(settings.dialect.value_or(ColaDialect::kBinary)),
      clock_(kTick, kTurnOfCounter) {}

void SickCola::start(Time now, Output& out) {
  clear_failure();
  telegrams_.clear();
  clock_.reset();
  transmitted_.reset();
  has_scan_ = false;
  password_ = 0;
  is_narrow_ = false;
  identity_.clear();
  named_front_.reset();
  if (settings_.only_listen) {
    state_ = State::kSpinUp;
    timer_.reset();
    return;
  }
  enter(State::kIdentify, now, out);
}

void SickCola::stop(Time, Output& out) {
  if (settings_.only_listen || state_ < State::kSubscribe) return;
  question_.clear();
  ColaWriter(dialect_, question_, "sEN LMDscandata").put(std::uint8_t{0});
  telegram_.clear();
  append_cola(telegram_, dialect_, question_);
  out.send(telegram_);
}

void SickCola::enter(State state, Time now, Output& out) {
  state_ = state;
  timer_.reset();
  if (state < State::kSpinUp) ask(now, out);
  if (state == State::kSpinUp) timer_.wait_until(now + kSpinUpTime);
}

void SickCola::ask(Time now, Output& out) {
  if (state_ == State::kIdentify && !settings_.dialect)
    dialect_ = timer_.attempts() % 2 == 0 ? ColaDialect::kBinary : ColaDialect::kAscii;
  write_question();
  telegram_.clear();
  append_cola(telegram_, dialect_, question_);
  out.send(telegram_);
  timer_.sent(now, state_ == State::kIdentify ? kAnswerTimeToIdentify : kSickColaAnswerTime);
}

void SickCola::write_question() {
  question_.clear();
  switch (state_) {
    case State::kIdentify:
      ColaWriter(dialect_, question_, "sRN DeviceIdent");
      break;
    case State::kLogin:
      ColaWriter(dialect_, question_, "sMN SetAccessMode")
          .put(kAuthorisedClient)
          .put(kPasswords[password_]);
      break;
    case State::kFields: {
      // Distances of the first echo (1, 0) with remission in 16 or 8 bits; no encoder (0, 0),
      // position, name or time; every scan.
      ColaWriter writer(dialect_, question_, "sWN LMDscandatacfg");
      writer.put(std::uint8_t{1}).put(std::uint8_t{0}).put(std::uint8_t{1});
      writer.put(static_cast<std::uint8_t>(is_narrow_ ? 0 : 1));
      constexpr int kZeros = 7;
      for (int i = 0; i < kZeros; ++i) writer.put(std::uint8_t{0});
      writer.put(std::uint16_t{1});
      break;
    }
    case State::kMeasure:
      ColaWriter(dialect_, question_, "sMN LMCstartmeas");
      break;
    case State::kRun:
      ColaWriter(dialect_, question_, "sMN Run");
      break;
    case State::kSubscribe:
    case State::kSpinUp:
    case State::kMeasuring:
      ColaWriter(dialect_, question_, "sEN LMDscandata").put(std::uint8_t{1});
      break;
  }
}

void SickCola::on_arrival(const Arrival& arrival, Output& out) {
  telegrams_.add(arrival);
  ColaTelegram telegram;
  while (telegrams_.next(telegram)) receive(telegram, out);
}

void SickCola::receive(const ColaTelegram& telegram, Output& out) {
  ColaReader reader(telegram);
  if (reader.name() == "LMDscandata" && (reader.kind() == "sSN" || reader.kind() == "sRA")) {
    take_scan(telegram);
    if (has_scan_ && state_ == State::kSpinUp) enter(State::kMeasuring, telegram.arrived, out);
    return;
  }
  if (reader.kind() == "sFA") ++errors_;
  // A recording may have the identity, too.
  if (settings_.only_listen && reader.kind() == "sRA" && reader.name() == "DeviceIdent")
    take_identity(reader);
  const bool waits = state_ < State::kSpinUp && telegram.dialect == dialect_ && !failure();
  if (!waits) return;
  if (reader.kind() == "sFA")
    on_error(reader, telegram.arrived, out);
  else if (is_answer(reader))
    on_answer(reader, telegram.arrived, out);
}

// "sRA DeviceIdent" is the answer to "sRN DeviceIdent", but "sAN Run" is the answer to "sMN Run".
bool SickCola::is_answer(const ColaReader& reader) const {
  const ColaReader question(dialect_, question_);
  if (question.kind() == "sMN") return reader.kind() == "sAN" && reader.name() == question.name();
  return reader.kind().substr(0, 2) == question.kind().substr(0, 2) &&
         reader.kind().ends_with('A') && reader.name() == question.name();
}

void SickCola::on_answer(ColaReader& reader, Time now, Output& out) {
  switch (state_) {
    case State::kIdentify:
      take_identity(reader);
      enter(State::kLogin, now, out);
      break;
    case State::kLogin:
      on_login(reader.take<std::uint8_t>() == 1, now, out);
      break;
    case State::kFields:
      enter(State::kMeasure, now, out);
      break;
    case State::kMeasure:
      if (reader.take<std::uint8_t>() != 0) note("does not start to measure");
      enter(State::kRun, now, out);
      break;
    case State::kRun:
      enter(State::kSubscribe, now, out);
      break;
    case State::kSubscribe:
      enter(State::kSpinUp, now, out);
      break;
    case State::kSpinUp:
    case State::kMeasuring:
      break;
  }
}

void SickCola::take_identity(ColaReader& reader) {
  identity_ = reader.take_string();
  named_front_ = front_of_name(identity_);
  if (!reader.at_end()) identity_.append(" ").append(reader.take_string());
}

ColaFront SickCola::front() const {
  if (settings_.front) return {.degrees = *settings_.front};
  if (named_front_) return *named_front_;
  const ColaChannel* const distances = cola_scan_.channel("DIST1");
  return distances == nullptr ? ColaFront{} : front_of_range(distances->start_angle);
}

void SickCola::on_login(bool is_in, Time now, Output& out) {
  if (is_in) {
    enter(State::kFields, now, out);
  } else if (++password_ < kPasswords.size()) {
    enter(State::kLogin, now, out);
  } else {
    note("accepts none of the default passwords; its configuration is not changed");
    enter(State::kSubscribe, now, out);
  }
}

void SickCola::on_error(ColaReader& reader, Time now, Output& out) {
  const auto number = reader.take<std::uint16_t>();
  const std::string_view text = cola_error_text(number);
  const std::string reason =
      "error " + std::to_string(number) + (text.empty() ? "" : ", " + std::string(text));
  switch (state_) {
    case State::kIdentify:
      enter(State::kLogin, now, out);  // a scanner without identity is accepted
      break;
    case State::kLogin:
      on_login(false, now, out);
      break;
    case State::kFields:
      if (!std::exchange(is_narrow_, true)) {
        enter(State::kFields, now, out);
        break;
      }
      note("refuses LMDscandatacfg: " + reason);
      enter(State::kMeasure, now, out);
      break;
    case State::kMeasure:
      note("refuses LMCstartmeas: " + reason);
      enter(State::kRun, now, out);
      break;
    case State::kRun:
      note("refuses Run: " + reason);
      enter(State::kSubscribe, now, out);
      break;
    case State::kSubscribe:
    case State::kSpinUp:
    case State::kMeasuring:
      fail(tims::Errc::kAnsweredError, "the scanner refuses to send LMDscandata: " + reason);
      break;
  }
}

void SickCola::note(std::string_view what) {
  notes_.append(notes_.empty() ? "" : "\n").append("the scanner ").append(what);
}

void SickCola::on_timeout(Time now, Output& out) {
  if (!timer_.take_due(now)) return;
  const bool both = state_ == State::kIdentify && !settings_.dialect;
  if (state_ == State::kSpinUp)
    fail(tims::Errc::kTimeout,
         "the scanner has accepted all requests, but sends no scan; check its display for errors");
  else if (timer_.may_repeat(both ? kAttemptsToIdentify : kSickColaAttempts))
    ask(now, out);
  else
    give_up();
}

void SickCola::give_up() {
  if (state_ != State::kIdentify) {
    const ColaReader question(dialect_, question_);
    fail(tims::Errc::kTimeout,
         "the scanner has stopped answering, at request " + std::string(question.name()));
  } else {
    fail(tims::Errc::kTimeout,
         settings_.dialect ? "no scanner answers in this protocol of CoLa; protocol=0 tries both"
                           : "no scanner answers, neither in CoLa B nor in CoLa A; check its port "
                             "(2111 or 2112) and that no other program is connected to it");
  }
}

void SickCola::take_scan(const ColaTelegram& telegram) {
  if (!decode_cola_scan(telegram, cola_scan_)) return;
  if (cola_scan_.layer_angle != 0) return;  // uses only the level layer
  if (settings_.serial_number != 0 && settings_.serial_number != cola_scan_.serial_number) {
    is_wanted("scanner", serial_number(), std::to_string(settings_.serial_number));
    return;
  }
  ColaView view = settings_.view;
  view.front = front();
  if (!scan_of_cola(cola_scan_, view, scan_)) return;
  has_scan_ = true;
  recorded_ = measured(telegram.arrived);
}

// The time at which the beam was in the middle of the scan. An LMS5xx reports the start of the
// turn. Other scanners transmit earlier after the reported time than a scan takes, so they report
// its end.
Time SickCola::measured(Time arrived) {
  const Duration scan = std::chrono::milliseconds(scan_.duration);
  const bool stands_still = transmitted_ == cola_scan_.transmitted;
  transmitted_ = cola_scan_.transmitted;
  if (stands_still) return arrived - scan / 2;
  const Time transmitted = clock_.to_host(cola_scan_.transmitted, arrived);
  const Duration since_started = kTick * (cola_scan_.transmitted - cola_scan_.started);
  const Duration turn = cola_scan_.turn();
  if (since_started >= scan && since_started < 3 * turn)
    return transmitted - since_started + turn / 2;
  const bool is_end = since_started < scan;
  return transmitted - (is_end ? since_started : Duration(0)) - scan / 2;
}

bool SickCola::take(LadarData& scan, Time& recorded) {
  if (!std::exchange(has_scan_, false)) return false;
  std::swap(scan, scan_);
  recorded = recorded_;
  return true;
}

}  // namespace rack::device
