// ObjRecogIbeoLux: sends the motion of the vehicle to an Ibeo Lux (or its computer) at a CAN
// interface. Its own data contain no objects, as in the original: LadarIbeoLux receives those.
#include <optional>

#include "components/devices/scanners/ego_motion.h"
#include "rack/devices/driver.h"
#include "rack/input.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/obj_recog.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 3>{{
    {"canDev", 0, "number N of the CAN interface canN", 0, 99},
    {"baseCanId", 0x500, "CAN id of data from the scanner; not used, as in the original", 0, 0x7FF},
    optional_partner("chassis", "the chassis", "the chassis that reports the motion; -1: none"),
}});

constexpr ModuleInfo kInfo{
    .program = "ObjRecogIbeoLux",
    .purpose = "Sends the motion of the vehicle to an Ibeo Lux at a CAN interface.",
    .class_id = tims::class_id::kObjRecog,
    .parameters = kParameters,
};

constexpr std::chrono::milliseconds kPeriod(1000);

class ObjRecogIbeoLux final : public DataModule<ObjRecogData> {
 public:
  ObjRecogIbeoLux() : DataModule(kInfo, {.history = 10}) {}

 private:
  Result<void> module_on() override {
    double wheel_base = 0;
    set_period(kPeriod);
    if (auto on = chassis_.turn_on(); !on) return on;
    if (chassis_) {
      const auto parameters = chassis_->get_parameter();
      if (!parameters) return parameters.error();
      wheel_base = static_cast<double>(parameters->wheelBase.raw());
      const auto granted = chassis_.subscribe();
      if (!granted) return granted.error();
      set_period(*granted);
    }
    motion_.emplace(wheel_base);
    auto opened = open();
    if (!opened) return opened.error();
    device_ = std::move(*opened);
    return DataModule::module_on();
  }

  Result<std::unique_ptr<Device>> open() {
    const std::string text = this->text("device");
    const auto address = text.empty() ? can_device(integer("canDev")) : DeviceAddress::parse(text);
    if (!address) return address.error();
    return Device::open({.address = *address, .baud = 0, .record = this->text("record")}, *motion_);
  }

  void module_off() override {
    chassis_.stop();
    device_.reset();
    motion_.reset();
  }

  Result<void> module_loop() override {
    if (!chassis_) {
      sleep_until_next(period());
    } else {
      if (auto come = chassis_.next(movement_, 2 * period()); !come) return come;
      motion_->set_motion({.speed = movement_.vx.raw(), .omega = movement_.omega.raw()});
    }
    if (auto sent = device_->wait(now()); !sent) return sent;
    get_local_buffer().recordingTime = chassis_ ? movement_.recordingTime : time_stamp();
    return put_local_buffer();
  }

  OwnMailbox work_{*this, 1, wire_size<ChassisParamData>()};
  Input<ChassisProxy> chassis_{*this, "chassis", work_, 2, wire_size<ChassisData>()};
  ChassisData movement_;
  std::optional<EgoMotion> motion_;
  std::unique_ptr<Device> device_;
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::ObjRecogIbeoLux objects;
  return objects.run(argc, argv);
}
