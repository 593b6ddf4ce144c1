// Where a device is, as text:
//
//   serial:/dev/serial/by-id/usb-FTDI-if00-port0?baud=500000
//   tcp:192.168.0.1:2112     tcp:[fe80::1%eth0]:2112
//   udp::2368                udp:192.168.0.201:2368    (what is sent goes there)
//   udp:127.0.0.1:2368?local=0                         (from any port of our own)
//   can:can0                 serial:/dev/ttyACM0?can=500000   (a bus behind a USB adapter)
//   usb:15d1:0000            usb:15d1:0000/H0712345
//   v4l:/dev/video0?size=640x480&format=MJPG,YUYV&rate=30   (the first format that it has)
//   gpio:/dev/gpiochip0?in=17,27&out=22                     (lines by their offsets)
//   pty:/tmp/lms             (a terminal that somebody else opens)
//   play:scans.cap?speed=max (what was recorded; speed: times as fast, "max": without waiting)
//
// The original counts its devices; its numbers become addresses here.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "tims/result.h"

namespace rack::device {

using tims::Result;

enum class TransportKind : std::uint8_t {
  kSerial,
  kTcp,
  kUdp,
  kCan,
  kUsb,
  kVideo,
  kGpio,
  kPlayback,
  kPty,
};

struct DeviceAddress {
  TransportKind kind = TransportKind::kSerial;
  std::string place{};  // path, interface, vendor:product[/serial number]; of tcp and udp the host
  std::uint16_t port = 0;
  std::map<std::string, std::string, std::less<>> options{};

  // kInvalidArgument says what is wrong, and what may stand there.
  static Result<DeviceAddress> parse(std::string_view text);
  [[nodiscard]] std::string to_string() const;

  // "baud": nothing when it is not said.
  [[nodiscard]] std::uint32_t baud(std::uint32_t otherwise) const;
  // "can" of a serial line: of the bus behind an adapter that speaks text (slcan.h); 0: it is none.
  [[nodiscard]] std::uint32_t can_bit_rate() const;
  // "speed" of what is played: 0 means as fast as it is taken.
  [[nodiscard]] double speed() const;

  bool operator==(const DeviceAddress&) const = default;
};

// serialDev of the original on Linux: 0 to 99 ttyS, 100 to 199 ttyUSB, 200 to 299 ttyACM.
Result<DeviceAddress> serial_device(std::int32_t number);
// canDev: canN.
Result<DeviceAddress> can_device(std::int32_t number);

}  // namespace rack::device
