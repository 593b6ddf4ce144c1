// The transports. Each has its own source file, which describes its addresses.
#pragma once

#include <vector>

#include "rack/devices/transport.h"

namespace rack::device {

// --- serial.cpp

tims::Result<std::unique_ptr<Transport>> open_serial(const DeviceAddress& address,
                                                     std::uint32_t baud);
// Creates a pseudo terminal and a link `place` to its other end, which an emulator opens.
tims::Result<std::unique_ptr<Transport>> open_pty(const DeviceAddress& address, std::uint32_t baud);

// --- slcan_adapter.cpp

// line: transport to the adapter.
tims::Result<std::unique_ptr<Transport>> open_slcan(std::unique_ptr<Transport> line,
                                                    std::uint32_t bit_rate);
// The same from the adapter's side, for emulators: sends and receives frames as text.
std::unique_ptr<Transport> slcan_frames(std::unique_ptr<Transport> line, std::uint32_t bit_rate);

// --- socket.cpp

// Waits for the connection for at most 1 s.
tims::Result<std::unique_ptr<Transport>> open_tcp(const DeviceAddress& address);
// Receives at the port. If the address has a host, sends to host:port and ignores datagrams from
// other hosts; otherwise sends to the sender of the last datagram.
tims::Result<std::unique_ptr<Transport>> open_udp(const DeviceAddress& address);

// --- can.cpp

// `wanted`: receives frames that match any of these filters; if empty, no frames.
tims::Result<std::unique_ptr<Transport>> open_can(const DeviceAddress& address,
                                                  const std::vector<CanFilter>& wanted);

// --- usb.cpp

tims::Result<std::unique_ptr<Transport>> open_usb(const DeviceAddress& address);

// --- gpio.cpp

tims::Result<std::unique_ptr<Transport>> open_gpio(const DeviceAddress& address);

// --- video.cpp

tims::Result<std::unique_ptr<Transport>> open_video(const DeviceAddress& address);

// Checks whether the camera supports the size in one of the formats, even while another program
// uses it. The error lists the supported ones.
tims::Result<void> check_video(const DeviceAddress& address);

// --- dcam.cpp, in a library of its own: programs that are linked to it need libdc1394

tims::Result<std::unique_ptr<Transport>> open_dcam(const DeviceAddress& address);

// Checks whether the camera has the size in one of the formats. The error lists what it has.
tims::Result<void> check_dcam(const DeviceAddress& address);

// --- video_source.cpp

// Starts the process that reads the video. It ends with the thread that calls this, or with the
// transport. Does not wait for the source: if that cannot be opened, receive() returns the error.
tims::Result<std::unique_ptr<Transport>> open_video_source(const DeviceAddress& address);

// --- playback.cpp

// `baud`: rate at which raw bytes are played.
tims::Result<std::unique_ptr<Transport>> open_playback(const DeviceAddress& address,
                                                       std::uint32_t baud);

// --- device.cpp

// The error for errno after open(2) of a device file, with advice. `group`: the group that has
// access.
tims::Error cannot_open_device(const std::string& path, std::string_view group);

}  // namespace rack::device
