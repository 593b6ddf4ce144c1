#include "components/devices/scanners/ibeo.h"

#include <numbers>

#include "components/devices/scanners/turning_ladar.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr unsigned kMany = 0xFFFF;
constexpr std::size_t kOfFrame = 6;   // bytes per frame of a long telegram
constexpr std::size_t kOfSingle = 2;  // bytes of a telegram of one frame
constexpr Duration kIbeoAnswerTime = 1s;
constexpr Duration kTurnTime = 5s;
constexpr Duration kIbeoSpinUp = 15s;
constexpr Duration kPoll = 500ms;
// The scanner needs a pause between frames.
constexpr Duration kPauseOfFrames = 5ms;
constexpr int kIbeoAttempts = 3;
constexpr i32 kIbeoRangeMax = 100'000;
constexpr u32 kIbeoTurnMilliseconds = 100;

void put(IbeoFrame& frame, std::size_t at, unsigned number) {
  frame[at] = static_cast<std::byte>(number >> 8);
  frame[at + 1] = static_cast<std::byte>(number);
}

std::uint16_t service_of(std::uint8_t state) {
  constexpr std::array<std::uint16_t, 8> kServices = {
      ibeo::kStatus,  ibeo::kNoProfiles, ibeo::kSetTime,  ibeo::kTurn,
      ibeo::kMeasure, ibeo::kStatus,     ibeo::kProfiles, 0};
  return kServices[state];
}

}  // namespace

void append_ibeo(std::vector<IbeoFrame>& out, std::uint8_t receiver, std::uint16_t service,
                 std::span<const std::byte> parameters) {
  IbeoFrame frame{};
  if (parameters.size() <= kOfSingle) {
    put(frame, 2, receiver);
    put(frame, 4, service);
    std::ranges::copy(parameters, frame.begin() + 6);
    out.push_back(frame);
    return;
  }
  const std::size_t following = (parameters.size() + kOfFrame - 1) / kOfFrame;
  put(frame, 0, kMany);
  put(frame, 2, static_cast<unsigned>(following + 1));
  put(frame, 4, receiver);
  put(frame, 6, service);
  out.push_back(frame);
  for (std::size_t left = following; left > 0; --left) {
    frame = {};
    put(frame, 0, static_cast<unsigned>(left));
    const auto part = parameters.first(std::min(kOfFrame, parameters.size()));
    std::ranges::copy(part, frame.begin() + 2);
    parameters = parameters.subspan(part.size());
    out.push_back(frame);
  }
}

IbeoTelegrams::IbeoTelegrams(std::uint8_t receiver) : receiver_(receiver) {
  parameters_.reserve(kLongest);
}

bool IbeoTelegrams::take(const Arrival& frame, IbeoTelegram& telegram) {
  if (frame.bytes.size() != 8) return false;
  const unsigned number = big_endian<std::uint16_t>(frame.bytes);
  // The start of a telegram discards an incomplete one; telegrams that are too long are ignored.
  if (number == kMany) {
    broken_ += left_ > 0 ? 1U : 0U;
    const unsigned count = big_endian<std::uint16_t>(frame.bytes, 2);
    const bool is_mine = static_cast<std::uint8_t>(frame.bytes[5]) == receiver_;
    const bool is_sane = count > 1 && (count - 1) * kOfFrame <= kLongest;
    left_ = is_mine && is_sane ? count - 1 : 0;
    service_ = big_endian<std::uint16_t>(frame.bytes, 6);
    began_ = frame.first;
    parameters_.clear();
    return false;
  }
  if (number == 0) {
    broken_ += left_ > 0 ? 1U : 0U;
    left_ = 0;
    if (static_cast<std::uint8_t>(frame.bytes[3]) != receiver_) return false;
    parameters_.assign(frame.bytes.begin() + 6, frame.bytes.end());
    telegram = {.service = big_endian<std::uint16_t>(frame.bytes, 4),
                .parameters = parameters_,
                .began = frame.first};
    return true;
  }
  // CAN may deliver a frame twice, if its sender missed the acknowledgement.
  if (number == left_ + 1) return false;
  if (number != left_) {
    broken_ += left_ > 0 ? 1U : 0U;
    left_ = 0;
    return false;
  }
  parameters_.insert(parameters_.end(), frame.bytes.begin() + 2, frame.bytes.end());
  if (--left_ > 0) return false;
  telegram = {.service = service_, .parameters = parameters_, .began = began_};
  return true;
}

unsigned IbeoProfile::take_u16() {
  const unsigned value = big_endian<std::uint16_t>(rest_);
  rest_ = rest_.subspan(2);
  return value;
}

bool IbeoProfile::begin(std::span<const std::byte> profile) {
  constexpr std::size_t kHead = 4;
  rest_ = profile;
  sectors_ = 0;
  if (profile.size() < kHead) return false;
  format_ = take_u16();
  sectors_ = take_u16() & 0xFF;  // the upper byte is the number of layers
  constexpr unsigned kNeeded =
      ibeo::kHasStep | ibeo::kHasPoints | ibeo::kHasFirstAngle | ibeo::kHasDistance;
  if ((format_ & kNeeded) != kNeeded) sectors_ = 0;
  for (const unsigned bit : {ibeo::kHasNumber, ibeo::kHasCount, ibeo::kHasLayer})
    if (has(bit) && can_read(2)) take_u16();
  return sectors_ > 0;
}

bool IbeoProfile::next(LadarData& scan, std::uint16_t& begin, std::uint16_t& end) {
  while (sectors_ > 0) {
    --sectors_;
    unsigned step = 0;
    unsigned points = 0;
    unsigned began = 0;
    unsigned first = 0;
    unsigned ended = 0;
    unsigned unused = 0;
    const auto read = [&](unsigned bit, unsigned& value) {
      if (!has(bit)) return true;
      if (!can_read(2)) return false;
      value = take_u16();
      return true;
    };
    const bool is_whole = read(ibeo::kHasSector, unused) && read(ibeo::kHasStep, step) &&
                          read(ibeo::kHasPoints, points) && read(ibeo::kHasBegin, began) &&
                          read(ibeo::kHasFirstAngle, first) &&
                          read_points(scan, points, first, step) && read(ibeo::kHasEnd, ended) &&
                          read(ibeo::kHasLastAngle, unused);
    if (!is_whole) {
      sectors_ = 0;
      return false;
    }
    begin = static_cast<std::uint16_t>(began);
    end = static_cast<std::uint16_t>(has(ibeo::kHasEnd) ? ended : began);
    if (points > 0) return true;
  }
  return false;
}

bool IbeoProfile::read_points(LadarData& scan, std::size_t points, unsigned first, unsigned step) {
  constexpr double kSixteenth = std::numbers::pi / 180 / 16;
  constexpr int kOfMetre = 256;
  const std::size_t size =
      std::size_t{2} * ((has(ibeo::kHasDistance) ? 1U : 0U) + (has(ibeo::kHasAngle) ? 1U : 0U) +
                        (has(ibeo::kHasEcho) ? 1U : 0U));
  if (points > decltype(LadarData::points)::kMax || !can_read(points * size)) return false;
  const double begin = first * kSixteenth - std::numbers::pi;
  scan.points.resize(points);
  for (std::size_t i = 0; i < points; ++i) {
    LadarPoint& point = scan.points[i];
    const unsigned distance = take_u16();
    const double angle = has(ibeo::kHasAngle) ? take_u16() * kSixteenth - std::numbers::pi
                                              : begin + static_cast<double>(i) * step * kSixteenth;
    point.angle = static_cast<f32>(within_turn(angle));
    point.distance = static_cast<i32>(distance * 1000 / kOfMetre);
    point.type = distance == 0 ? ladar_point::kInvalid : ladar_point::kUnknown;
    point.intensity = has(ibeo::kHasEcho) ? static_cast<i32>(take_u16()) : 0;
  }
  scan.maxRange = kIbeoRangeMax;
  scan.duration = kIbeoTurnMilliseconds;
  if (points > 0) {
    scan.startAngle = scan.points[0].angle;
    scan.endAngle = scan.points[points - 1].angle;
  }
  return true;
}

Ibeo::Ibeo(const IbeoSettings& settings) : settings_(settings) {
  constexpr std::size_t kFramesMax = 16;
  frames_.reserve(kFramesMax);
  constexpr std::size_t kProfileMax = 1 << 14;
  bytes_.reserve(kProfileMax);
}

void Ibeo::start(Time now, Output& out) {
  clear_failure();
  telegrams_.clear();
  clock_.reset();
  profile_ = {};
  timer_.reset();
  next_frame_at_ = tims::kNever;
  has_measured_ = false;
  state_ = State::kMeasuring;
  if (!settings_.only_listen) enter(State::kStatus, now, out);
}

// Stops the motor, without waiting for answers.
void Ibeo::stop(Time, Output& out) {
  if (settings_.only_listen) return;
  for (const std::uint16_t service : {ibeo::kNoProfiles, ibeo::kTurn, ibeo::kIdle}) {
    frames_.clear();
    append_ibeo(frames_, settings_.sensor, service, {});
    out.send(frames_[0], ibeo::kHostId);
  }
}

void Ibeo::enter(State state, Time now, Output& out) {
  state_ = state;
  timer_.reset();
  if (state == State::kSpinUp) spin_up_end_ = now + kIbeoSpinUp;
  ask(now, out);
}

void Ibeo::ask(Time now, Output& out) {
  frames_.clear();
  sent_ = 0;
  constexpr std::array<std::byte, 4> kAllProfiles = {std::byte{}, std::byte{},
                                                     static_cast<std::byte>(ibeo::kWanted >> 8),
                                                     static_cast<std::byte>(ibeo::kWanted & 0xFF)};
  // Sets the clock to 0 and uses the configured speed.
  constexpr std::array<std::byte, 2> kNone{};
  const bool has_parameter = state_ == State::kTime || state_ == State::kTurn;
  append_ibeo(frames_, settings_.sensor, service_of(static_cast<std::uint8_t>(state_)),
              state_ == State::kProfiles ? std::span<const std::byte>(kAllProfiles)
              : has_parameter            ? std::span<const std::byte>(kNone)
                                         : std::span<const std::byte>{});
  const bool is_slow = state_ == State::kTurn || state_ == State::kMeasure;
  timer_.sent(now, is_slow ? kTurnTime : kIbeoAnswerTime);
  send_next(now, out);
}

void Ibeo::send_next(Time now, Output& out) {
  out.send(frames_[sent_++], ibeo::kHostId);
  next_frame_at_ = sent_ < frames_.size() ? now + kPauseOfFrames : tims::kNever;
}

void Ibeo::on_timeout(Time now, Output& out) {
  if (next_frame_at_ <= now) send_next(now, out);
  if (!timer_.take_due(now)) return;
  const bool polls = state_ == State::kSpinUp && now < spin_up_end_;
  if (polls || timer_.may_repeat(kIbeoAttempts)) return ask(now, out);
  // The scanner refuses to stop profiles if none were requested.
  if (state_ == State::kQuiet) return enter(State::kTime, now, out);
  std::string why = "scanner " + std::to_string(settings_.sensor) + " ";
  if (state_ == State::kStatus)
    why += "does not answer; check the bit rate of the interface (1 Mbit/s) and sensorId";
  else if (state_ == State::kSpinUp)
    why += "does not start to measure within 15 s";
  else
    why += "has stopped answering";
  fail(tims::Errc::kTimeout, std::move(why));
}

void Ibeo::on_arrival(const Arrival& arrival, Output& out) {
  if (arrival.id != (ibeo::kSensorId | settings_.sensor)) return;
  IbeoTelegram telegram;
  if (!telegrams_.take(arrival, telegram)) return;
  if (telegram.service == (ibeo::kProfiles | ibeo::kAnswer)) {
    if (state_ != State::kProfiles && state_ != State::kMeasuring) return;
    bytes_.assign(telegram.parameters.begin(), telegram.parameters.end());
    if (!profile_.begin(bytes_)) return;
    came_ = telegram.began;
    has_measured_ = true;
    state_ = State::kMeasuring;
    timer_.stop();
  } else if (state_ != State::kMeasuring &&
             telegram.service == (service_of(static_cast<std::uint8_t>(state_)) | ibeo::kAnswer)) {
    take_answer(telegram, arrival.last, out);
  }
}

void Ibeo::take_answer(const IbeoTelegram& telegram, Time now, Output& out) {
  const bool has_status = state_ != State::kTime;
  if (has_status && !check_status(telegram.parameters)) return;
  switch (state_) {
    case State::kStatus:
      enter(State::kQuiet, now, out);
      break;
    case State::kQuiet:
      enter(State::kTime, now, out);
      break;
    case State::kTime:
      enter(State::kTurn, now, out);
      break;
    case State::kTurn:
      enter(State::kMeasure, now, out);
      break;
    case State::kMeasure:
      if (check_measure(telegram.parameters)) enter(State::kSpinUp, now, out);
      break;
    case State::kSpinUp:
      if (mode_ == ibeo::kModeMeasuring)
        enter(State::kProfiles, now, out);
      else
        timer_.wait_until(now + kPoll);
      break;
    case State::kProfiles:
    case State::kMeasuring:
      break;
  }
}

// Four bytes: communication, system, measurement, and motor with mode.
bool Ibeo::check_status(std::span<const std::byte> status) {
  if (status.size() < 4) return false;
  const auto last = std::to_integer<unsigned>(status[3]);
  mode_ = last & 0xF;
  const unsigned motor = last >> 4;
  constexpr unsigned kCoderError = 0xB;
  if (mode_ != ibeo::kModeError && motor != kCoderError) return true;
  fail(tims::Errc::kSystem, motor == kCoderError
                                ? "the scanner's motor has stopped: encoder error"
                                : "the scanner reports a defect, system status " +
                                      std::to_string(std::to_integer<unsigned>(status[1])));
  return false;
}

bool Ibeo::check_measure(std::span<const std::byte> answer) {
  if (answer.size() < 6) return false;
  const unsigned error = big_endian<std::uint16_t>(answer, 4);
  if (error == 0) return true;
  constexpr std::array<std::string_view, 5> kErrors = {
      "", "pulse frequency of the laser too high", "mean pulse frequency of the laser too high",
      "invalid sector borders", "a sector border is not a multiple of the step"};
  fail(tims::Errc::kInvalidArgument,
       "the scanner does not measure: " +
           (error < kErrors.size() ? std::string(kErrors[error]) : std::to_string(error)) +
           "; change its configuration");
  return false;
}

bool Ibeo::take(LadarData& scan, Time& recorded) {
  std::uint16_t begin = 0;
  std::uint16_t end = 0;
  if (!profile_.next(scan, begin, end)) return false;
  const auto took = static_cast<std::uint16_t>(end - begin);
  recorded = clock_.to_host(end, came_) - std::chrono::milliseconds(took) / 2;
  return true;
}

}  // namespace rack::device
