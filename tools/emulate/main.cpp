// rack-emulate: emulates a device at the end of a line.
#include <cstdio>

#include <fmt/core.h>

#include "components/devices/emulators/emulators.h"
#include "rack/devices/emulator.h"
#include "tools/cli/argument_parser.h"

namespace rack::device {
namespace {

using timsctl::Exit;
using timsctl::Failure;

// Throws a Failure if there is an error.
template <typename T>
void check(const tims::Result<T>& result, Exit exit = Exit::kNo) {
  if (!result)
    throw Failure(exit, std::string(tims::name(result.error().code())), result.error().message());
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
  const auto address = DeviceAddress::parse(where.empty() ? info->address : where);
  check(address, Exit::kUsage);
  const auto emulator = info->make({});
  check(rack::device::emulate(*address, info->baud, record, *emulator, [&] {
    fmt::print("{} at {}, for driver {}\n", info->device, address->to_string(), info->driver);
    std::fflush(stdout);
  }));
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
