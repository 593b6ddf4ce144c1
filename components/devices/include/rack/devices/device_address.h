// The address of a device as text:
//
//   serial:/dev/serial/by-id/usb-FTDI-if00-port0?baud=500000
//   tcp:192.168.0.1:2112     tcp:[fe80::1%eth0]:2112
//   udp::2368                udp:192.168.0.201:2368    (host: destination of sent datagrams)
//   udp:127.0.0.1:2368?local=0                         (0: any free local port)
//   can:can0                 serial:/dev/ttyACM0?can=500000   (a bus behind a USB adapter)
//   usb:15d1:0000            usb:15d1:0000/H0712345
//   v4l:/dev/video0?size=640x480&format=MJPG,YUYV&rate=30   (first format the camera supports)
//   dcam:00b09d0100a1b2c3?size=1280x960&format=UYVY&rate=15&speed=400   (IIDC camera by its GUID)
//   dcam:0                   (the first IIDC camera, in the order of the GUIDs)
//   gpio:/dev/gpiochip0?in=17,27&out=22                     (offsets of the lines)
//   rtsp://192.168.0.90/stream1   http://192.168.0.90/video.mjpg   (cameras in the network; also
//                            https:, rtsps:; all behind the name belongs to the camera)
//   file:corridor.mp4?loop=1&speed=2   /data/corridor.mp4   ./pictures?rate=10   (a video, or a
//                            folder of pictures: rate is that of its pictures)
//   gstreamer:videotestsrc ! videoconvert      (a pipeline that delivers pictures)
//   pty:/tmp/lms             (creates a pseudo terminal, which another program opens)
//   play:scans.cap?speed=max (plays a recording; speed: a factor, or "max": without waiting)
//
// The original RACK numbers its devices; this file converts these numbers to addresses.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "tims/result.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

using tims::Result;

enum class TransportKind : std::uint8_t {
  kSerial,
  kTcp,
  kUdp,
  kCan,
  kUsb,
  kVideo,
  kDcam,
  kGpio,
  kPlayback,
  kPty,
  kStream,
  kFile,
  kGstreamer,
};

struct DeviceAddress {
  TransportKind kind = TransportKind::kSerial;
  // Path, interface, vendor:product[/serial number], GUID, host of tcp and udp, whole URL, or
  // pipeline.
  std::string place{};
  std::uint16_t port = 0;
  std::map<std::string, std::string, std::less<>> options{};

  // The text of kInvalidArgument states what is wrong and gives a valid example.
  static Result<DeviceAddress> parse(std::string_view text);
  [[nodiscard]] std::string to_string() const;
  // For logs, errors and recordings: as to_string(), but passwords are replaced by "***".
  [[nodiscard]] std::string shown() const;

  // Option "baud", or `otherwise` if the address has none.
  [[nodiscard]] std::uint32_t baud(std::uint32_t otherwise) const;
  // Option "can" of a serial line: bit rate of the bus behind an SLCAN adapter (slcan.h); 0: the
  // line is not an adapter.
  [[nodiscard]] std::uint32_t can_bit_rate() const;
  // Option "speed" of a recording: a factor; 0: as fast as the reader takes the data.
  [[nodiscard]] double speed() const;
  // Option "rate" of a file: pictures per second; 0: not given.
  [[nodiscard]] double rate() const;
  // Option "loop" of a recording: begins again at its end.
  [[nodiscard]] bool loops() const;

  bool operator==(const DeviceAddress&) const = default;
};

// Parameter serialDev of the original on Linux: 0 to 99 ttyS, 100 to 199 ttyUSB, 200 to 299 ttyACM.
Result<DeviceAddress> serial_device(std::int32_t number);
// Parameter canDev: number N of interface canN.
Result<DeviceAddress> can_device(std::int32_t number);
// 16 hex digits.
std::string guid_text(std::uint64_t guid);
// Parameter cameraGuid: 0 is the first camera. The original compares the lower 32 bits of the GUID,
// as a decimal number with a sign; a whole GUID is also accepted, decimal or hexadecimal with 0x.
Result<DeviceAddress> dcam_device(std::string_view guid);

// Replaces the passwords of URLs in a text by stars.
std::string without_passwords(std::string text);

}  // namespace rack::device

#pragma GCC visibility pop
