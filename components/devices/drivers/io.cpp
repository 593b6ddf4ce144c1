// Io: driver of digital and analog I/O of the computer or of a board.
#include <mutex>
#include <vector>

#include "base/text.h"
#include "components/devices/pins/firmata.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 7>{{
    {"serialDev", 200, "serial device of the board: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0,
     299},
    {"baudrate", 57600, "baud rate of the board's Firmata [bit/s]", 9600, 1000000},
    {"periodTime", 100, "maximum period [ms]; changes are reported at once", 20, 5000},
    {"inputs", "", "pins of the board, e.g. 2,3,4; for gpio: use option in= of the address"},
    {"outputs", "", "pins of the board, e.g. 12,13; for gpio: use option out= of the address"},
    {"analogInputs", "", "analog inputs of the board, e.g. 0,1"},
    {"pullUp", 0, "1: enable the pull-up resistors of the board's inputs", 0, 1},
}});

constexpr ModuleInfo kInfo{
    .program = "Io",
    .purpose = "Digital and analog I/O: pins of the computer (gpio:) or of a board with Firmata.",
    .class_id = tims::class_id::kIo,
    .parameters = kParameters,
};

Result<std::vector<std::uint16_t>> pins_of(std::string_view list, std::string_view name,
                                           unsigned most) {
  std::vector<std::uint16_t> pins;
  while (!list.empty()) {
    const std::string_view one = list.substr(0, list.find(','));
    list.remove_prefix(std::min(list.size(), one.size() + 1));
    const auto pin = tims::base::parse_number<std::uint16_t>(one);
    if (!pin || *pin > most)
      return tims::Error(tims::Errc::kInvalidArgument, std::string(name) +
                                                           " must be numbers from 0 to " +
                                                           std::to_string(most) + "; example: 2,3");
    pins.push_back(*pin);
  }
  return pins;
}

class Io : public Driver<IoData, IoLines> {
 public:
  Io() : Driver(kInfo, {.history = 100, .size_max = 8 + kValuesMax}) {}

 private:
  static constexpr std::size_t kValuesMax = 3 * 128;

  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, static_cast<std::uint32_t>(integer("baudrate")));
  }

  Result<std::unique_ptr<IoLines>> make_dialogue() override {
    const auto period = std::chrono::milliseconds(integer("periodTime"));
    set_period(period);
    const auto address = DeviceAddress::parse(text("device"));
    const bool is_gpio = address && address->kind == TransportKind::kGpio;
    const auto list = [&](std::string_view parameter, std::string_view option) {
      constexpr unsigned kBoardMost = 127;
      if (!is_gpio) return pins_of(text(parameter), parameter, kBoardMost);
      const auto given = address->options.find(option);
      return pins_of(given == address->options.end() ? "" : given->second, option, 0xFFFF);
    };
    const auto inputs = list("inputs", "in");
    const auto outputs = list("outputs", "out");
    const auto analogs = list("analogInputs", "analog");
    for (const auto* pins : {&inputs, &outputs, &analogs})
      if (!*pins) return pins->error();
    const IoSettings settings{.layout = {.inputs = *inputs,
                                         .outputs = *outputs,
                                         .analogs = *analogs,
                                         .pull_up = integer("pullUp") != 0},
                              .period = period,
                              .only_listen = is_recording()};
    {
      const std::lock_guard lock(pending_mutex_);
      outputs_ = outputs->size();
      has_pending_ = false;
    }
    if (is_gpio) return std::unique_ptr<IoLines>(std::make_unique<GpioPins>(settings));
    return std::unique_ptr<IoLines>(std::make_unique<Firmata>(settings));
  }

  Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != IoType::kSetData) return Driver::module_command(message);
    const auto outputs = decode<IoData>(message);
    if (!outputs) return outputs.error();
    if (!is_on()) return refused("the component is off");
    {
      const std::lock_guard lock(pending_mutex_);
      if (outputs->values.size() != outputs_)
        return refused("there are " + std::to_string(outputs_) + " outputs, not " +
                       std::to_string(outputs->values.size()));
      pending_.assign(outputs->values.begin(), outputs->values.end());
      has_pending_ = true;
    }
    wake();
    reply(message.header, tims::type::kOk);
    return {};
  }

  tims::Time prepare(tims::Time) override {
    const std::lock_guard lock(pending_mutex_);
    if (std::exchange(has_pending_, false)) dialogue().set(pending_);
    return tims::kNever;
  }

  std::mutex pending_mutex_;
  std::vector<u8> pending_;
  std::size_t outputs_ = 0;
  bool has_pending_ = false;
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::Io io;
  return io.run(argc, argv);
}
