#include "components/devices/camera/ptz_camera.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

namespace rack::device::emulator {
namespace {

using visca::Kind;

constexpr std::byte operator""_b(unsigned long long value) { return static_cast<std::byte>(value); }

constexpr double kPanStep = 60;  // steps/s per step of speed; maximum 100 deg/s
constexpr double kTiltStep = 72;
constexpr double kZoomStep = 1024;

double number(std::byte byte) { return std::to_integer<int>(byte); }
bool begins(std::span<const std::byte> message, std::initializer_list<std::byte> with) {
  return message.size() >= with.size() && std::equal(with.begin(), with.end(), message.begin());
}

}  // namespace

void PtzCamera::Axis::advance(double seconds) {
  const double distance = velocity * seconds;
  const bool is_there = std::abs(target - is) <= std::abs(distance);
  is = std::clamp(is_there ? target : is + distance, min, max);
  if (is_there || (is == min && velocity < 0) || (is == max && velocity > 0)) velocity = 0;
}

void PtzCamera::Axis::go_to(double place, double speed) {
  target = std::clamp(place, min, max);
  velocity = target > is ? speed : target < is ? -speed : 0;
}

void PtzCamera::Axis::go(double wanted) {
  velocity = wanted;
  target = wanted < 0 ? std::numeric_limits<double>::lowest() : std::numeric_limits<double>::max();
}

void PtzCamera::start(Time now, Output&) {
  last_ = now;
  messages_.clear();
}

void PtzCamera::advance(Time now) {
  const double seconds = std::chrono::duration<double>(now - last_).count();
  last_ = now;
  for (Axis* const axis : {&pan_, &tilt_, &zoom_}) axis->advance(seconds);
}

void PtzCamera::on_arrival(const Arrival& arrival, Output& out) {
  advance(arrival.last);
  if (!is_datagrams_) {
    messages_.add(arrival);
    while (const auto message = messages_.next()) on_message(*message, 0, out);
    return;
  }
  const auto datagram = visca::parse_datagram(arrival.bytes);
  if (!datagram) return;
  if (datagram->kind == Kind::kControl) {
    constexpr std::array kDone = {0x01_b};
    sending_.clear();
    visca::append_datagram(sending_, Kind::kControlReply, datagram->number, kDone);
    out.send(sending_);
  } else {
    on_message(datagram->message, datagram->number, out);
  }
}

void PtzCamera::on_message(std::span<const std::byte> message, std::uint32_t number, Output& out) {
  constexpr std::array kAcknowledge = {0x41_b};
  constexpr std::array kCompleted = {0x51_b};
  constexpr std::array kSyntax = {0x60_b, 0x02_b};
  if (begins(message, {0x88_b, 0x30_b, 0x01_b})) {
    constexpr std::array kAddresses = {0x88_b, 0x30_b, 0x02_b, visca::kEnd};
    out.send(kAddresses);
  } else if (begins(message, {0x81_b, 0x09_b, 0x06_b, 0x12_b})) {
    std::vector<std::byte> body = {0x50_b};
    visca::append_nibbles(body, static_cast<int>(std::lround(pan_.is)));
    visca::append_nibbles(body, static_cast<int>(std::lround(tilt_.is)));
    reply(body, number, out);
  } else if (begins(message, {0x81_b, 0x09_b, 0x04_b, 0x47_b})) {
    std::vector<std::byte> body = {0x50_b};
    visca::append_nibbles(body, static_cast<int>(std::lround(zoom_.is)));
    reply(body, number, out);
  } else if (begins(message, {0x81_b, 0x01_b})) {
    const bool is_good = obey(message);
    if (is_good) reply(kAcknowledge, number, out);
    reply(is_good ? std::span<const std::byte>(kCompleted) : kSyntax, number, out);
  } else if (begins(message, {0x81_b})) {
    reply(kSyntax, number, out);
  }
}

bool PtzCamera::obey(std::span<const std::byte> command) {
  const auto body = command.subspan(2, command.size() - 3);
  if (begins(body, {0x06_b, 0x04_b})) {
    pan_.go_to(0, kPanStep * 24);
    tilt_.go_to(0, kTiltStep * 20);
  } else if (begins(body, {0x06_b, 0x02_b}) && body.size() == 12) {
    pan_.go_to(visca::nibbles(body.subspan(4)), kPanStep * number(body[2]));
    tilt_.go_to(visca::nibbles(body.subspan(8)), kTiltStep * number(body[3]));
  } else if (begins(body, {0x06_b, 0x01_b}) && body.size() == 6) {
    const double pan = body[4] == 0x01_b ? -1 : body[4] == 0x02_b ? 1 : 0;
    const double tilt = body[5] == 0x01_b ? 1 : body[5] == 0x02_b ? -1 : 0;
    pan_.go(pan * kPanStep * number(body[2]));
    tilt_.go(tilt * kTiltStep * number(body[3]));
  } else if (begins(body, {0x04_b, 0x47_b}) && body.size() == 6) {
    zoom_.go_to(visca::nibbles(body.subspan(2)), kZoomStep * 8);
  } else if (begins(body, {0x04_b, 0x07_b}) && body.size() == 3) {
    const double speed = kZoomStep * (number(body[2] & 0x0F_b) + 1);
    const std::byte direction = body[2] & 0xF0_b;
    zoom_.go(direction == 0x20_b ? speed : direction == 0x30_b ? -speed : 0);
  } else {
    return false;
  }
  return true;
}

void PtzCamera::reply(std::span<const std::byte> body, std::uint32_t number, Output& out) {
  message_.assign(1, 0x90_b);
  message_.insert(message_.end(), body.begin(), body.end());
  message_.push_back(visca::kEnd);
  if (!is_datagrams_) {
    out.send(message_);
    return;
  }
  sending_.clear();
  visca::append_datagram(sending_, Kind::kReply, number, message_);
  out.send(sending_);
}

}  // namespace rack::device::emulator
