#include "rack/devices/device.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <poll.h>

#include "components/devices/io/guard.h"
#include "components/devices/io/transports.h"
#include "components/files/capture_file.h"
#include "os/clock.h"
#include "os/file.h"
#include "rack/devices/replay.h"

namespace rack::device {

using tims::Errc;
using tims::Error;
using tims::Result;

namespace {

// Opens a serial line, or the CAN bus behind an adapter on it.
Result<std::unique_ptr<Transport>> open_serial_line(const DeviceAddress& address,
                                                    std::uint32_t baud) {
  constexpr std::uint32_t kBaud = 115200;
  const std::uint32_t bit_rate = address.can_bit_rate();
  const std::uint32_t rate = baud == 0 ? kBaud : baud;
  auto line =
      address.kind == TransportKind::kPty ? open_pty(address, rate) : open_serial(address, rate);
  if (!line || bit_rate == 0) return line;
  return open_slcan(std::move(*line), bit_rate);
}

}  // namespace

Error cannot_open_device(const std::string& path, std::string_view group) {
  const int error = errno;
  Error all = tims::os::system_error(path);
  if (error == EACCES)
    return {Errc::kSystem, all.detail() + "; add the user to the group of the device (" +
                               std::string(group) + ")"};
  if (error == ENOENT)
    return {Errc::kSystem, all.detail() + "; check that it is plugged in: timsctl device list"};
  return all;
}

std::vector<std::vector<std::byte>> Transport::to_write(
    const std::vector<Telegram>& telegrams) const {
  std::vector<std::vector<std::byte>> pieces;
  pieces.reserve(telegrams.size());
  for (const Telegram& telegram : telegrams) pieces.push_back(telegram.bytes);
  return pieces;
}

Result<std::unique_ptr<Transport>> open_transport(const DeviceAddress& address, std::uint32_t baud,
                                                  const std::vector<CanFilter>& wanted) {
  switch (address.kind) {
    case TransportKind::kSerial:
    case TransportKind::kPty:
      return open_serial_line(address, baud);
    case TransportKind::kTcp:
      return open_tcp(address);
    case TransportKind::kUdp:
      return open_udp(address);
    case TransportKind::kCan:
      return open_can(address, wanted);
    case TransportKind::kPlayback:
      return open_playback(address, baud);
    case TransportKind::kVideo:
      return open_video(address);
    case TransportKind::kDcam:
      return Error(Errc::kInvalidArgument,
                   address.to_string() + " can only be opened by CameraDcam");
    case TransportKind::kGpio:
      return open_gpio(address);
    case TransportKind::kUsb:
      return open_usb(address);
    case TransportKind::kStream:
    case TransportKind::kFile:
    case TransportKind::kGstreamer:
      return open_video_source(address);
  }
  return Error(Errc::kInvalidArgument, "no transport for " + address.to_string());
}

Result<std::unique_ptr<Device>> Device::open(const DeviceOptions& options, Dialogue& dialogue,
                                             Take take) {
  const bool is_dcam = options.open_dcam != nullptr && options.address.kind == TransportKind::kDcam;
  auto transport = is_dcam
                       ? options.open_dcam(options.address)
                       : open_transport(options.address, options.baud, dialogue.wanted_frames());
  if (!transport) return transport.error();
  std::unique_ptr<CaptureFile> capture;
  if (!options.record.empty()) {
    auto created = CaptureFile::create(options.record, options.address.shown(), tims::os::now());
    if (!created) return created.error();
    capture = std::move(*created);
  }
  // The guard must start before the first command is sent. A recording needs none.
  std::unique_ptr<Guard> guard;
  const auto stop_commands = dialogue.stop_commands();
  if (!stop_commands.empty() && !(*transport)->is_recording()) {
    auto started = Guard::start((*transport)->descriptor(), (*transport)->to_write(stop_commands));
    if (!started) return started.error();
    guard = std::move(*started);
  }
  auto device = with(std::move(*transport), std::move(capture), dialogue, std::move(take));
  device->guard_ = std::move(guard);
  return device;
}

std::unique_ptr<Device> Device::with(std::unique_ptr<Transport> transport, Dialogue& dialogue,
                                     Take take) {
  return with(std::move(transport), nullptr, dialogue, std::move(take));
}

std::unique_ptr<Device> Device::with(std::unique_ptr<Transport> transport,
                                     std::unique_ptr<CaptureFile> capture, Dialogue& dialogue,
                                     Take take) {
  return std::unique_ptr<Device>(
      new Device(std::move(transport), std::move(capture), dialogue, std::move(take)));
}

Device::Device(std::unique_ptr<Transport> transport, std::unique_ptr<CaptureFile> capture,
               Dialogue& dialogue, Take take)
    : transport_(std::move(transport)),
      capture_(std::move(capture)),
      dialogue_(dialogue),
      receive_([this](const Arrival& arrival) { hand_over(arrival); }),
      conversation_(dialogue, std::move(take)) {
  const Time now = tims::os::now();
  note(now, Direction::kStarted);
  conversation_.start(now, *this);
}

Device::~Device() { close(); }

void Device::close() {
  if (std::exchange(is_closed_, true)) return;
  if (!lost_) dialogue_.stop(tims::os::now(), *this);
  guard_.reset();  // the guard keeps the line open
  if (capture_) capture_->finish();
}

Result<void> Device::wait(Time until, int also) {
  if (auto good = state(); !good) return good;
  const Time next = std::min(until, next_timeout());
  std::array<pollfd, 2> there{{{.fd = transport_->descriptor(), .events = POLLIN, .revents = 0},
                               {.fd = also, .events = POLLIN, .revents = 0}}};
  const Time now = tims::os::now();
  const auto wait = tims::os::to_timespec(Time(std::max(Duration(0), next - now)));
  if (::ppoll(there.data(), there.size(), next == tims::kNever ? nullptr : &wait, nullptr) < 0 &&
      errno != EINTR)
    return tims::os::system_error("poll");
  if (auto received = transport_->receive(tims::os::now(), receive_); !received) {
    if (capture_) capture_->add_event(tims::os::now(), received.error().detail());
    lost_ = received.error();
    return received;
  }
  const Time then = tims::os::now();
  if (dialogue_.next_timeout() <= then) {
    note(then, Direction::kTime);
    conversation_.on_timeout(then, *this);
  }
  return state();
}

std::optional<std::string> Device::take_event() {
  auto event = transport_->take_event();
  if (!capture_) return event;
  if (!event) event = capture_->take_event();
  if (event && !is_closed_) capture_->add_event(tims::os::now(), *event);
  return event;
}

Result<void> Device::state() {
  if (lost_) return *lost_;
  return conversation_.state();
}

void Device::hand_over(const Arrival& arrival) {
  if (arrival.is_restart) {
    note(arrival.last, Direction::kStarted);
    conversation_.start(arrival.last, *this);
    return;
  }
  note(arrival.last, arrival.is_sent ? Direction::kSent : Direction::kReceived, arrival);
  conversation_.receive(arrival, *this);
}

void Device::note(Time when, Direction direction, const Arrival& arrival) {
  if (!capture_) return;
  if (direction != Direction::kSent) ++records_;
  capture_->add(when, direction, arrival.id, arrival.bytes, arrival.last - arrival.first);
}

void Device::note_made(Time measured, std::span<const std::byte> message) {
  if (capture_) capture_->add(measured, Direction::kMade, records_, checksum_of(message));
}

// Bytes received at the previous rate are discarded.
void Device::set_baud(std::uint32_t baud) {
  conversation_.drop_rest();
  transport_->set_baud(baud);
}

void Device::send_before(Time deadline, std::span<const std::byte> bytes, std::uint32_t id) {
  if (lost_) return;
  const Time now = tims::os::now();
  if (capture_) capture_->add(now, Direction::kSent, id, bytes);
  auto sent = deadline == tims::kNever ? transport_->send(now, bytes, id)
                                       : transport_->send_before(now, deadline, bytes, id);
  if (sent) return;
  lost_ = sent.error();
  conversation_.end();
}

}  // namespace rack::device
