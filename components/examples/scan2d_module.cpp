// A component that processes the data of another one: Scan2dModule of the paper on RACK.
#include <array>
#include <cmath>

#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/scan2d.h"

namespace {

constexpr std::int8_t kClearCommand = rack::kFirstCommand;  // specific to this component

constexpr std::array<rack::ParameterInfo, 1> kParameters = {{
    rack::partner("ladar", "the ladar"),  // ladarSys and ladarInst
}};

constexpr rack::ModuleInfo kInfo{.program = "Scan2dModule",
                                 .purpose = "The points of a laser scan.",
                                 .class_id = tims::class_id::kScan2d,
                                 .parameters = kParameters};

class Scan2dModule : public rack::DataModule<rack::Scan2dData> {
 public:
  Scan2dModule() : DataModule(kInfo, {.history = 10}) { rack::reserve_all(scan_); }

 private:
  // Commands of this component; DataModule handles those of all components with data.
  rack::Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != kClearCommand) return DataModule::module_command(message);
    reply(message.header, tims::type::kOk);
    return {};
  }

  rack::Result<void> module_on() override {
    const auto period = ladar_.start();
    if (!period) return period.error();
    set_period(*period);
    return DataModule::module_on();
  }

  void module_off() override {
    DataModule::module_off();
    ladar_.stop();
  }

  rack::Result<void> module_loop() override {
    if (auto come = ladar_.next(scan_, std::chrono::seconds(1)); !come) return come;
    rack::Scan2dData& buffer = get_local_buffer();
    calculate(buffer);
    return put_local_buffer();
  }

  void calculate(rack::Scan2dData& buffer) const {
    buffer.recordingTime = scan_.recordingTime;
    buffer.maxRange = scan_.maxRange;
    buffer.points.resize(scan_.points.size());
    for (std::size_t i = 0; i < scan_.points.size(); ++i) {
      const rack::LadarPoint& seen = scan_.points[i];
      const auto distance = static_cast<float>(seen.distance);
      buffer.points[i].x = static_cast<int>(distance * std::cos(seen.angle));
      buffer.points[i].y = static_cast<int>(distance * std::sin(seen.angle));
      buffer.points[i].type = seen.type;
    }
  }

  rack::OwnMailbox work_{*this, 1, 128};  // for answers of the ladar
  rack::Input<rack::LadarProxy> ladar_{*this, "ladar", work_, 4, rack::body_max<rack::LadarData>()};
  rack::LadarData scan_;
};

}  // namespace

int main(int argc, char** argv) {
  Scan2dModule scan;
  return scan.run(argc, argv);
}
