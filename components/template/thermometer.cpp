// Thermometer: tells a temperature, and whether it is above a limit.
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

// Each is an option, a parameter that SET_PARAM changes, and a line of --help.
constexpr std::array<rack::ParameterInfo, 4> kParameters = {{
    {"sensor", "", "file with thousandths of degrees Celsius, as of hwmon; none: simulated"},
    {"period", 100, "ms", 10, 60000},
    {"smoothing", 4, "samples that are averaged", 1, 16},
    {"limit", 353150, "too hot above, mK", 0, 2e6},
}};

constexpr rack::ModuleInfo kInfo{
    .program = "Thermometer",
    .purpose = "Tells a temperature, and whether it is above a limit.",
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

  // By the command task; the answer of what goes wrong is ERROR, with its words.
  rack::Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != ThermometerType::kSetLimit)
      return DataModule::module_command(message);
    const auto wanted = rack::decode<ThermometerLimit>(message);
    if (!wanted) return wanted.error();
    if (wanted->limit < 0) return refused("nothing is colder than 0 K");
    limit_ = wanted->limit.raw();
    reply(message.header, tims::type::kOk);
    return {};
  }

  rack::Result<int> measure() {
    const std::string path = text("sensor");
    if (path.empty()) return kIcePoint + 20000 + static_cast<int>(rack::time_stamp().raw() % 1000);
    int celsius = 0;
    std::ifstream file(path);
    if (!(file >> celsius)) return refused(path + ": cannot be read, or is no number");
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
