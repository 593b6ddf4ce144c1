// The ways to a device, a source of its own each, which says how it is reached there.
#pragma once

#include <vector>

#include "components/devices/io/transport.h"
#include "os/file.h"

namespace rack::device {

// --- serial.cpp

tims::Result<std::unique_ptr<Transport>> open_serial(const DeviceAddress& address,
                                                     std::uint32_t baud);
// A terminal of its own, whose other end `place` becomes a link to: an emulator opens it.
tims::Result<std::unique_ptr<Transport>> open_pty(const DeviceAddress& address, std::uint32_t baud);

// Both ends of a pseudo terminal; `path` is a link to the other one, which is held open: who opens
// and closes it is no end. `baud`: that it is set to; 0: it hands nothing back, all else is for
// whoever opens it.
struct Terminal {
  tims::os::File own;
  tims::os::File other;
};
tims::Result<Terminal> make_terminal(const std::string& path, std::uint32_t baud);

// --- slcan_adapter.cpp

// line: to the adapter.
tims::Result<std::unique_ptr<Transport>> open_slcan(std::unique_ptr<Transport> line,
                                                    std::uint32_t bit_rate);
// The same from the adapter's side, with the bus behind it: frames come and go as text.
std::unique_ptr<Transport> slcan_frames(std::unique_ptr<Transport> line, std::uint32_t bit_rate);

// --- socket.cpp

// Waits for the connection, 1 s at most.
tims::Result<std::unique_ptr<Transport>> open_tcp(const DeviceAddress& address);
// Receives at the port; sends to place:port, where the address has a place, else to who was heard
// last. Datagrams of others than a place that is given are left out.
tims::Result<std::unique_ptr<Transport>> open_udp(const DeviceAddress& address);

// --- can.cpp

// `wanted`: frames that fit any of them; none: no frames at all.
tims::Result<std::unique_ptr<Transport>> open_can(const DeviceAddress& address,
                                                  const std::vector<CanFilter>& wanted);

// --- usb.cpp

tims::Result<std::unique_ptr<Transport>> open_usb(const DeviceAddress& address);

// --- gpio.cpp

tims::Result<std::unique_ptr<Transport>> open_gpio(const DeviceAddress& address);

// --- video.cpp

tims::Result<std::unique_ptr<Transport>> open_video(const DeviceAddress& address);

// Whether the camera has that size in one of the formats, although somebody uses it now; the error
// says what it has.
tims::Result<void> check_video(const DeviceAddress& address);

// --- playback.cpp

// `baud`: the pace of raw bytes.
tims::Result<std::unique_ptr<Transport>> open_playback(const DeviceAddress& address,
                                                       std::uint32_t baud);

// --- device.cpp

// The error of errno after open(2) of a device's file, with what to do about it. `group`: whose
// members may.
tims::Error cannot_open_device(const std::string& path, std::string_view group);

}  // namespace rack::device
