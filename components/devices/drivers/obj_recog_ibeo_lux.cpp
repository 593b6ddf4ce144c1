// ObjRecogIbeoLux: sends the motion of the vehicle to an Ibeo Lux (or its computer) at a CAN
// interface. Its own data contain no objects, as in the original: LadarIbeoLux receives those.
#include <optional>

#include "components/devices/drivers/driver.h"
#include "components/devices/scanners/ego_motion.h"
#include "rack/input.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/obj_recog.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 4>{{
    {"canDev", 0, "number N of the CAN interface canN", 0, 99},
    {"baseCanId", 0x500, "CAN id of data from the scanner; not used, as in the original", 0, 0x7FF},
    {"chassisSys", 0, "system id of the chassis", 0, kIdMax},
    {"chassisInst", -1, "instance of the chassis that reports the motion; -1: none", -1, kIdMax},
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
  Result<void> module_init() override {
    const auto work = create_mailbox(1, wire_size<ChassisParamData>());
    if (!work) return work.error();
    return create_input(chassis_, **work, 2, wire_size<ChassisData>());
  }

  Result<void> module_on() override {
    double wheel_base = 0;
    set_period(kPeriod);
    has_chassis_ = integer("chassisInst") >= 0;
    if (has_chassis_) {
      const auto chassis = address_of(tims::class_id::kChassis, "chassis");
      if (auto on = chassis_->turn_on(chassis); !on) return on;
      const auto parameters = chassis_->proxy().get_parameter();
      if (!parameters) return parameters.error();
      wheel_base = static_cast<double>(parameters->wheelBase.raw());
      const auto granted = chassis_->subscribe();
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
    chassis_->stop();
    device_.reset();
    motion_.reset();
  }

  Result<void> module_loop() override {
    if (!has_chassis_) {
      sleep_until_next(period());
    } else {
      if (auto come = chassis_->next(movement_, 2 * period()); !come) return come;
      motion_->tell({.speed = movement_.vx.raw(), .omega = movement_.omega.raw()});
    }
    if (auto sent = device_->wait(now()); !sent) return sent;
    get_local_buffer().recordingTime = has_chassis_ ? movement_.recordingTime : time_stamp();
    return put_local_buffer();
  }

  std::optional<Input<ChassisProxy>> chassis_;
  bool has_chassis_ = false;
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
