#include "components/devices/scanners/sick_cola_emulator.h"

#include <algorithm>
#include <numbers>

namespace rack::device::emulator {
namespace {

// Error numbers of sFA.
constexpr unsigned kAccessDenied = 1;
constexpr unsigned kUnknownMethod = 2;
constexpr unsigned kUnknownVariable = 3;
constexpr unsigned kWrongData = 5;
constexpr unsigned kSickColaEmulatorUnknownCommand = 12;
constexpr unsigned kUnknownEvent = 15;

// Time since power-on of the scanner at the start of the emulation.
constexpr Duration kOnBefore = std::chrono::minutes(7);

}  // namespace

std::vector<ColaScan> scans_of_cola(std::span<const std::byte> stream, std::size_t most) {
  std::vector<ColaScan> scans;
  ColaTelegrams telegrams;
  ColaTelegram telegram;
  constexpr std::size_t kPiece = 1024;
  while (!stream.empty() && scans.size() < most) {
    const auto piece = stream.first(std::min(kPiece, stream.size()));
    stream = stream.subspan(piece.size());
    telegrams.add({.bytes = piece});
    while (telegrams.next(telegram) && scans.size() < most)
      if (ColaScan scan; decode_cola_scan(telegram, scan)) scans.push_back(std::move(scan));
  }
  return scans;
}

void SickColaEmulator::start(Time now, Output& /*out*/) {
  switched_on_ = now - kOnBefore;
  is_logged_in_ = measures_ = sends_scans_ = has_remission_ = is_wide_ = false;
  turns_since_ = answer_at_ = scan_at_ = tims::kNever;
  telegrams_.clear();
  answers_.clear();
}

Duration SickColaEmulator::turn() const {
  constexpr std::int64_t kHundredSeconds = 100'000'000'000;
  return Duration(kHundredSeconds / std::max(1U, settings_.scan_frequency));
}

Duration SickColaEmulator::scan_time() const {
  constexpr std::int64_t kUnitsOfTurn = 3'600'000;
  return turn() * ((settings_.values - 1) * std::int64_t{settings_.step}) / kUnitsOfTurn;
}

std::uint32_t SickColaEmulator::counter(Time now) const {
  const auto since = std::chrono::duration_cast<std::chrono::microseconds>(now - switched_on_);
  return static_cast<std::uint32_t>(since.count());
}

void SickColaEmulator::on_arrival(const Arrival& arrival, Output& /*out*/) {
  telegrams_.add(arrival);
  ColaTelegram telegram;
  while (telegrams_.next(telegram)) {
    if (telegram.dialect != settings_.dialect) continue;
    take_command(telegram, arrival.last);
    if (answer_at_ == tims::kNever) answer_at_ = arrival.last + settings_.answer_time;
  }
}

void SickColaEmulator::take_command(const ColaTelegram& telegram, Time now) {
  ColaReader reader(telegram);
  if (reader.kind() == "sRN")
    take_read(reader);
  else if (reader.kind() == "sWN")
    take_write(reader);
  else if (reader.kind() == "sMN")
    take_method(reader, now);
  else if (reader.kind() == "sEN")
    take_event(reader, now);
  else
    refuse(kSickColaEmulatorUnknownCommand);
}

void SickColaEmulator::append_answer(std::string_view kind, std::string_view name,
                                     std::initializer_list<unsigned> bytes) {
  body_.clear();
  ColaWriter writer(settings_.dialect, body_, std::string(kind) + " " + std::string(name));
  for (const unsigned byte : bytes) writer.put(static_cast<std::uint8_t>(byte));
  append_cola(answers_, settings_.dialect, body_);
}

// In CoLa B there is no blank before the number.
void SickColaEmulator::refuse(unsigned number) {
  body_.clear();
  if (settings_.dialect == ColaDialect::kAscii)
    ColaWriter(settings_.dialect, body_, "sFA").put(static_cast<std::uint16_t>(number));
  else
    body_ = {std::byte{'s'}, std::byte{'F'}, std::byte{'A'}, std::byte{0},
             static_cast<std::byte>(number)};
  append_cola(answers_, settings_.dialect, body_);
  ++errors_sent_;
}

void SickColaEmulator::take_read(ColaReader& reader) {
  body_.clear();
  if (reader.name() == "DeviceIdent") {
    ColaWriter(settings_.dialect, body_, "sRA DeviceIdent")
        .put_string(settings_.device)
        .put_string(settings_.version);
  } else if (reader.name() == "FirmwareVersion") {
    ColaWriter(settings_.dialect, body_, "sRA FirmwareVersion").put_string(settings_.version);
  } else if (reader.name() == "SCdevicestate") {
    ColaWriter(settings_.dialect, body_, "sRA SCdevicestate").put(std::uint8_t{0});
  } else if (reader.name() == "LMPoutputRange") {
    const std::int32_t end = settings_.start_angle + (settings_.values - 1) * settings_.step;
    ColaWriter(settings_.dialect, body_, "sRA LMPoutputRange")
        .put(std::uint16_t{1})
        .put(std::uint32_t{settings_.step})
        .put(settings_.start_angle)
        .put(end);
  } else if (reader.name() == "LMDscandata" && scans_sent_ > 0) {
    append_cola_scan(body_, settings_.dialect, scan_, "sRA LMDscandata");
  } else {
    return refuse(kUnknownVariable);
  }
  append_cola(answers_, settings_.dialect, body_);
}

void SickColaEmulator::take_write(ColaReader& reader) {
  if (reader.name() != "LMDscandatacfg") return refuse(kUnknownVariable);
  if (!is_logged_in_) return refuse(kAccessDenied);
  const auto channels = reader.take<std::uint8_t>();
  reader.take<std::uint8_t>();
  const bool has_remission = reader.take<std::uint8_t>() != 0;
  const bool is_wide = reader.take<std::uint8_t>() != 0;
  constexpr int kRest = 7;
  for (int i = 0; i < kRest; ++i) reader.take<std::uint8_t>();
  const auto every = reader.take<std::uint16_t>();
  const bool fits = reader.good() && reader.at_end() && channels == 1 && every == 1;
  if (!fits || (is_wide && !settings_.has_wide_remission)) return refuse(kWrongData);
  has_remission_ = has_remission;
  is_wide_ = is_wide;
  append_answer("sWA", "LMDscandatacfg", {});
}

void SickColaEmulator::take_method(ColaReader& reader, Time now) {
  if (reader.name() == "SetAccessMode") {
    const auto level = reader.take<std::uint8_t>();
    is_logged_in_ = reader.take<std::uint32_t>() == settings_.password && level >= 3;
    return append_answer("sAN", "SetAccessMode", {is_logged_in_ ? 1U : 0U});
  }
  const bool starts = reader.name() == "LMCstartmeas";
  if (!starts && reader.name() != "LMCstopmeas" && reader.name() != "Run")
    return refuse(kUnknownMethod);
  if (!is_logged_in_) return refuse(kAccessDenied);
  if (reader.name() == "Run") {
    is_logged_in_ = false;
    return append_answer("sAN", "Run", {1});
  }
  if (starts && !measures_) turns_since_ = now + settings_.spin_up;
  measures_ = starts;
  append_answer("sAN", starts ? "LMCstartmeas" : "LMCstopmeas", {0});
  begin_scans(now);
}

void SickColaEmulator::take_event(ColaReader& reader, Time now) {
  if (reader.name() != "LMDscandata") return refuse(kUnknownEvent);
  sends_scans_ = reader.take<std::uint8_t>() != 0;
  append_answer("sEA", "LMDscandata", {sends_scans_ ? 1U : 0U});
  begin_scans(now);
}

void SickColaEmulator::begin_scans(Time now) {
  if (!sends_scans_ || !measures_) {
    scan_at_ = tims::kNever;
  } else if (scan_at_ == tims::kNever) {
    const Duration first = scan_time() + settings_.transmits_after;
    Time begin = std::max(now, turns_since_);
    begin += turn() - (begin - turns_since_) % turn();
    scan_at_ = begin + first;
  }
}

void SickColaEmulator::on_timeout(Time now, Output& out) {
  if (answer_at_ <= now) {
    answer_at_ = tims::kNever;
    out.send(answers_);
    answers_.clear();
  }
  while (scan_at_ <= now) {
    make_scan(scan_at_ - settings_.transmits_after - scan_time());
    send_scan(out);
    scan_at_ += turn();
  }
}

// As in an LMS1xx, the reported time is that of the end of the scan.
void SickColaEmulator::make_scan(Time started) {
  if (!settings_.scans.empty()) {
    const std::size_t next = scans_sent_ % settings_.scans.size();
    scan_ = settings_.scans[next];
  } else {
    scan_ = {.version = 1, .device_number = 1, .measuring_frequency = 360};
    scan_.scan_frequency = settings_.scan_frequency;
    scan_.channels.resize(has_remission_ ? 2 : 1);
    scan_.channel_count = scan_.channels.size();
    for (std::size_t i = 0; i < scan_.channel_count; ++i) {
      ColaChannel& channel = scan_.channels[i];
      const std::string_view name = i == 0 ? "DIST1" : "RSSI1";
      std::ranges::copy(name, channel.content.begin());
      channel.start_angle = settings_.start_angle;
      channel.step = settings_.step;
      channel.is_wide = i == 0 || is_wide_;
      channel.values.resize(settings_.values);
    }
    for (std::size_t i = 0; i < settings_.values; ++i) {
      const double degrees =
          90 - (settings_.start_angle + static_cast<double>(i) * settings_.step) / 10000;
      const Time when = started + scan_time() * static_cast<std::int64_t>(i) /
                                      std::max<std::int64_t>(1, settings_.values - 1);
      const double distance = settings_.sight(degrees * std::numbers::pi / 180, 0, when);
      constexpr double kRange = 65535;
      scan_.channels[0].values[i] =
          distance > kRange ? 0 : static_cast<std::uint16_t>(std::lround(distance));
      if (has_remission_) scan_.channels[1].values[i] = is_wide_ ? 500 : 100;
    }
  }
  scan_.serial_number = settings_.serial_number;
  scan_.telegram_counter = static_cast<std::uint16_t>(scans_sent_ + 1);
  scan_.scan_counter = scan_.telegram_counter;
  scan_.started = counter(started + scan_time());
  scan_.transmitted = counter(scan_at_);
  measured_ = started + scan_time() / 2;
  ++scans_sent_;
}

void SickColaEmulator::send_scan(Output& out) {
  body_.clear();
  append_cola_scan(body_, settings_.dialect, scan_);
  telegram_.clear();
  append_cola(telegram_, settings_.dialect, body_);
  out.send(telegram_);
}

}  // namespace rack::device::emulator
