// A program that emulates a device at the end of a line, for its driver:
//
//   int main(int argc, char** argv) {
//     HeadingCompass compass;  // a rack::device::Dialogue, from the device's side
//     return rack::device::run_emulator(argc, argv, {.name = "heading", .address =
//     "pty:/tmp/heading",
//                                                    .baud = 9600}, compass);
//   }
//
// The line has the true data rate: bytes at another rate arrive as noise.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "rack/devices/device_address.h"
#include "rack/devices/dialogue.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

struct EmulatorSettings {
  std::string_view name{};     // of the device, for users
  std::string_view address{};  // default: "pty:PATH", "tcp:127.0.0.1:PORT", "can:INTERFACE", ...
  std::uint32_t baud = 0;      // rate of its serial line at power-on; 0: no rate
};

// Arguments: [ADDRESS] [--record FILE]. Returns the exit status: 0 after SIGINT or SIGTERM, 1 with
// a text if the line cannot be opened or is lost, 2 for wrong arguments.
int run_emulator(int argc, char** argv, const EmulatorSettings& settings, Dialogue& device);

// The same for programs with arguments of their own. `record`: path of a capture, or empty. `ready`
// is called when the line is open. Returns after SIGINT or SIGTERM.
tims::Result<void> emulate(const DeviceAddress& address, std::uint32_t baud,
                           const std::string& record, Dialogue& device,
                           const std::function<void()>& ready);

}  // namespace rack::device

#pragma GCC visibility pop
