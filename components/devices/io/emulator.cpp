#include "rack/devices/emulator.h"

#include <csignal>
#include <cstdio>
#include <optional>

#include "components/devices/io/line.h"
#include "components/files/capture_file.h"
#include "os/clock.h"
#include "rack/devices/device.h"

namespace rack::device {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

volatile std::sig_atomic_t emulator_must_end = 0;  // written only by the signal handler

void on_end_signal(int) { emulator_must_end = 1; }

struct EmulatorArguments {
  std::string address;
  std::string record{};
};

std::optional<EmulatorArguments> emulator_arguments(int argc, char** argv,
                                                    std::string_view address) {
  EmulatorArguments arguments{.address = std::string(address)};
  bool has_address = false;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "--record" && i + 1 < argc) {
      arguments.record = argv[++i];
    } else if (!argument.starts_with('-') && !has_address) {
      arguments.address = argument;
      has_address = true;
    } else {
      return {};
    }
  }
  if (arguments.address.empty()) return {};
  return arguments;
}

}  // namespace

tims::Result<void> emulate(const DeviceAddress& address, std::uint32_t baud,
                           const std::string& record, Dialogue& device,
                           const std::function<void()>& ready) {
  auto line = open_line(address, baud);
  if (!line) return line.error();
  std::unique_ptr<CaptureFile> capture;
  if (!record.empty()) {
    auto created = CaptureFile::create(record, address.shown(), tims::os::now());
    if (!created) return created.error();
    capture = std::move(*created);
  }
  struct sigaction action {};
  action.sa_handler = on_end_signal;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  const auto served = Device::with(std::move(*line), std::move(capture), device);
  ready();
  constexpr Duration kLook = std::chrono::milliseconds(500);
  while (emulator_must_end == 0)
    if (auto waited = served->wait(tims::os::now() + kLook); !waited) return waited;
  return {};
}

int run_emulator(int argc, char** argv, const EmulatorSettings& settings, Dialogue& device) {
  const auto arguments = emulator_arguments(argc, argv, settings.address);
  if (!arguments) {
    (void)std::fprintf(
        stderr,
        "Usage: %s [ADDRESS] [--record FILE]\n\nEmulates the device \"%.*s\". ADDRESS: "
        "pty:PATH, tcp:127.0.0.1:PORT (listens), can:INTERFACE or udp:HOST:PORT; "
        "default: %.*s\n",
        argc > 0 ? argv[0] : "emulator", static_cast<int>(settings.name.size()),
        settings.name.data(), static_cast<int>(settings.address.size()), settings.address.data());
    return kWrongUse;
  }
  const auto address = DeviceAddress::parse(arguments->address);
  if (!address) {
    (void)std::fprintf(stderr, "%s\n", address.error().detail().c_str());
    return kWrongUse;
  }
  const auto ended = emulate(*address, settings.baud, arguments->record, device, [&] {
    std::printf("%.*s at %s\n", static_cast<int>(settings.name.size()), settings.name.data(),
                address->to_string().c_str());
    (void)std::fflush(stdout);
  });
  if (ended) return 0;
  (void)std::fprintf(stderr, "%s\n", ended.error().detail().c_str());
  return kFailed;
}

}  // namespace rack::device
