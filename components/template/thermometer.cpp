// Thermometer: measures a temperature, and compares it with a limit.
#include "thermometer.h"

#include <array>
#include <atomic>
#include <fstream>

#include <rack/clock.h>
#include <rack/data_module.h>

#include "smoothing.h"

namespace thermometer {
namespace {

constexpr int kIcePoint = 273150;  // mK

// Each parameter is a command line option, can be changed by SET_PARAM, and has a line in --help.
constexpr std::array<rack::ParameterInfo, 4> kParameters = {{
    rack::host_file(
        {"sensor", "",
         "file with the temperature in 1/1000 degrees Celsius, as from hwmon; empty: simulated"}),
    {"period", 100, "period of the data [ms]", 10, 60000},
    {"smoothing", 4, "number of samples to average", 1, 16},
    {"limit", 353150, "limit for tooHot [mK]", 0, 2e6},
}};

constexpr rack::ModuleInfo kInfo{
    .program = "Thermometer",
    .purpose = "Measures a temperature, and compares it with a limit.",
    .class_id = kThermometer,
    .parameters = kParameters,
    .own_class = &kThermometerClass,
};

class Thermometer : public rack::DataModule<ThermometerData> {
 public:
  Thermometer() : DataModule(kInfo, {.history = 10}) {}

 private:
  rack::Result<void> module_on() override {
    smoothing_ = Smoothing(static_cast<std::size_t>(integer("smoothing")));
    limit_ = integer("limit");
    set_period(std::chrono::milliseconds(integer("period")));
    return DataModule::module_on();
  }

  rack::Result<void> module_loop() override {
    sleep_until_next(period());
    ThermometerData& data = get_local_buffer();
    data.recordingTime = rack::time_stamp();
    const auto sample = measure();
    if (!sample) return sample.error();
    smoothing_.add(*sample);
    data.temperature = smoothing_.mean();
    data.limit = limit_.load();
    data.tooHot = data.temperature > data.limit ? 1 : 0;
    data.samples.assign(smoothing_.samples().begin(), smoothing_.samples().end());
    return put_local_buffer();
  }

  // Called by the command task; an error is answered by ERROR with its text.
  rack::Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != ThermometerType::kSetLimit)
      return DataModule::module_command(message);
    const auto wanted = rack::decode<ThermometerLimit>(message);
    if (!wanted) return wanted.error();
    if (wanted->limit < 0) return refused("the limit must not be below 0 K");
    limit_ = wanted->limit.raw();
    reply(message.header, tims::type::kOk);
    return {};
  }

  rack::Result<int> measure() {
    const std::string path = text("sensor");
    if (path.empty()) return kIcePoint + 20000 + static_cast<int>(rack::time_stamp().raw() % 1000);
    int celsius = 0;
    std::ifstream file(path);
    if (!(file >> celsius)) return refused(path + ": cannot be read, or is not a number");
    return kIcePoint + celsius;
  }

  Smoothing smoothing_{1};
  std::atomic<int> limit_ = 0;
};

}  // namespace
}  // namespace thermometer

int main(int argc, char** argv) {
  thermometer::Thermometer component;
  return component.run(argc, argv);
}
