// rack-emulate: emulates a device at the end of a line.
#include <csignal>
#include <cstdio>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <unistd.h>

#include "components/devices/emulators/emulators.h"
#include "components/devices/io/device.h"
#include "components/devices/io/line.h"
#include "os/clock.h"

namespace rack::device {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;

volatile std::sig_atomic_t asked_to_end = 0;  // written only by the signal handler

void on_signal(int) { asked_to_end = 1; }

int fail(int code, const tims::Error& error) {
  fmt::print(stderr, "rack-emulate: {}\n", error.message());
  return code;
}

int list() {
  for (const EmulatorInfo& info : emulators())
    fmt::print("{:<14} {:<34} {:<20} {}\n", info.name, info.device, info.driver, info.address);
  return 0;
}

int emulate(const std::string& name, const std::string& where, const std::string& record) {
  const EmulatorInfo* const info = find_emulator(name);
  if (info == nullptr)
    return fail(kWrongUsage, {tims::Errc::kInvalidArgument,
                              "no emulator " + name + "; rack-emulate --list shows all"});
  const auto address = DeviceAddress::parse(where.empty() ? info->address : where);
  if (!address) return fail(kWrongUsage, address.error());
  auto line = open_line(*address, info->baud);
  if (!line) return fail(kFailed, line.error());
  std::unique_ptr<CaptureFile> capture;
  if (!record.empty()) {
    auto created = CaptureFile::create(record, address->to_string(), tims::os::now());
    if (!created) return fail(kFailed, created.error());
    capture = std::move(*created);
  }
  struct sigaction action {};
  action.sa_handler = on_signal;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  const auto emulator = info->make({});
  const auto device = Device::with(std::move(*line), std::move(capture), *emulator);
  fmt::print("{} at {}, for driver {}\n", info->device, address->to_string(), info->driver);
  std::fflush(stdout);
  constexpr Duration kLook = std::chrono::milliseconds(500);
  while (asked_to_end == 0)
    if (auto waited = device->wait(tims::os::now() + kLook); !waited)
      return fail(kFailed, waited.error());
  return 0;
}

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  CLI::App app("Emulate a device, to test its driver or to work without the device.",
               "rack-emulate");
  std::string name;
  std::string address;
  std::string record;
  bool lists = false;
  app.add_flag("--list", lists, "list the devices, their drivers and default addresses");
  app.add_option("NAME", name, "name of the device");
  app.add_option(
      "ADDRESS", address,
      "where to serve it: pty:PATH, tcp:127.0.0.1:PORT (listens), can:INTERFACE, udp:HOST:PORT");
  app.add_option("--record", record, "record received and sent bytes in this file");
  app.set_version_flag("--version", TIMS_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : rack::device::kWrongUsage;
  }
  if (lists) return rack::device::list();
  if (name.empty()) {
    fmt::print(stderr, "rack-emulate: NAME is missing; rack-emulate --list shows all devices\n");
    return rack::device::kWrongUsage;
  }
  return rack::device::emulate(name, address, record);
}
