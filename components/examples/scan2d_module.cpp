// A component that processes the data of another one: Scan2dModule of the paper on RACK.
#include <cmath>
#include <optional>

#include "rack/data_module.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/scan2d.h"

namespace {

constexpr std::int8_t kClearCommand = rack::kFirstCommand;  // specific to this component

constexpr rack::ModuleInfo kInfo{.program = "Scan2dModule",
                                 .purpose = "The points of a laser scan.",
                                 .class_id = tims::class_id::kScan2d};

class Scan2dModule : public rack::DataModule<rack::Scan2dData> {
 public:
  Scan2dModule() : DataModule(kInfo, {.history = 10}) { rack::reserve_all(scan_); }

 private:
  rack::Result<void> module_init() override {
    const auto work = create_mailbox(1, 128);
    if (!work) return work.error();
    const auto ladar_mbx = create_mailbox(4, rack::body_max<rack::LadarData>());
    if (!ladar_mbx) return ladar_mbx.error();
    ladar_mbx_ = *ladar_mbx;
    ladar_.emplace(**work, address_of(tims::class_id::kLadar, integer("system"), 0));
    return DataModule::module_init();
  }

  // Commands of this component; DataModule handles those of all components with data.
  rack::Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != kClearCommand) return DataModule::module_command(message);
    reply(message.header, tims::type::kOk);
    return {};
  }

  rack::Result<void> module_on() override {
    if (auto on = ladar_->on(); !on) return on;
    const auto period = ladar_->get_cont_data(0, ladar_mbx_->address());
    if (!period) return period.error();
    set_period(std::chrono::milliseconds(period->raw()));
    return DataModule::module_on();
  }

  void module_off() override {
    DataModule::module_off();
    (void)ladar_->stop_cont_data(ladar_mbx_->address());
  }

  rack::Result<void> module_loop() override {
    const auto message = ladar_mbx_->peek_for(std::chrono::seconds(1));
    if (!message) return message.error();
    if (auto good = ladar_->decode_stream(*message, scan_); !good) return good;
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

  tims::Mailbox* ladar_mbx_ = nullptr;
  std::optional<rack::LadarProxy> ladar_;
  rack::LadarData scan_;
};

}  // namespace

int main(int argc, char** argv) {
  Scan2dModule scan;
  return scan.run(argc, argv);
}
