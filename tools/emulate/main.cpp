// rack-emulate: emulates a device at the end of a line.
#include <csignal>
#include <cstdio>

#include <fmt/core.h>
#include <unistd.h>

#include "components/devices/emulators/emulators.h"
#include "components/devices/io/device.h"
#include "components/devices/io/line.h"
#include "os/clock.h"
#include "tools/cli/argument_parser.h"

namespace rack::device {
namespace {

using timsctl::Exit;
using timsctl::Failure;

volatile std::sig_atomic_t asked_to_end = 0;  // written only by the signal handler

void on_signal(int) { asked_to_end = 1; }

// Returns the value, or throws a Failure.
template <typename T>
T well(tims::Result<T> result, Exit exit = Exit::kNo) {
  if (!result)
    throw Failure(exit, std::string(tims::name(result.error().code())), result.error().message());
  return std::move(result).value();
}

Exit list() {
  for (const EmulatorInfo& info : emulators())
    fmt::print("{:<14} {:<34} {:<20} {}\n", info.name, info.device, info.driver, info.address);
  return Exit::kDone;
}

Exit emulate(const std::string& name, const std::string& where, const std::string& record) {
  const EmulatorInfo* const info = find_emulator(name);
  if (info == nullptr)
    throw timsctl::usage_error("no emulator " + name, "rack-emulate --list shows all");
  const auto address =
      well(DeviceAddress::parse(where.empty() ? info->address : where), Exit::kUsage);
  auto line = well(open_line(address, info->baud));
  std::unique_ptr<CaptureFile> capture;
  if (!record.empty())
    capture = well(CaptureFile::create(record, address.to_string(), tims::os::now()));
  struct sigaction action {};
  action.sa_handler = on_signal;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  const auto emulator = info->make({});
  const auto device = Device::with(std::move(line), std::move(capture), *emulator);
  fmt::print("{} at {}, for driver {}\n", info->device, address.to_string(), info->driver);
  std::fflush(stdout);
  constexpr Duration kLook = std::chrono::milliseconds(500);
  while (asked_to_end == 0)
    if (auto waited = device->wait(tims::os::now() + kLook); !waited)
      throw Failure(Exit::kNo, "no_device", waited.error().message());
  return Exit::kDone;
}

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  using namespace rack::device;
  std::string name;
  std::string address;
  std::string record;
  bool lists = false;
  timsctl::ArgumentParser parser(
      "rack-emulate", "Emulate a device, to test its driver or to work without the device.");
  parser.flag("--list", lists, "list the devices, their drivers and default addresses");
  parser.argument("NAME", name, "name of the device");
  parser.argument(
      "ADDRESS", address,
      "where to serve it: pty:PATH, tcp:127.0.0.1:PORT (listens), can:INTERFACE, udp:HOST:PORT");
  parser.option("--record", record, "record received and sent bytes in this file");
  return parser.run(argc, argv, [&] {
    if (lists) return list();
    if (name.empty())
      throw timsctl::usage_error("NAME is missing", "rack-emulate --list shows all devices");
    return emulate(name, address, record);
  });
}
