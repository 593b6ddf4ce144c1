// ObjRecogRelayLadar: publishes objects that a ladar sends to its first mailbox as data of an
// ObjRecog: transforms them to robot coordinates and adds the position of the robot.
#include <array>

#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/partner.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/position.h"

namespace rack::device {
namespace {

constexpr auto kLargest = static_cast<std::int32_t>(body_max<ObjRecogData>());

constexpr std::array<ParameterInfo, 5> kParameters = {{
    at_start({"maxDataSize", kLargest, "maximum size of a received message [bytes]", 56, kLargest}),
    {"periodTime", 1000, "period of the ladar's objects [ms]", 1, 60000},
    optional_partner("position", "the position", "the position, for refPos; -1: none"),
    {"ladarOffsetX", 0, "position of the ladar on the robot, x [mm]"},
    {"ladarOffsetY", 0, "the same, y [mm]"},
}};

constexpr ModuleInfo kInfo{
    .program = "ObjRecogRelayLadar",
    .purpose = "Publishes objects recognised by a ladar as data of an ObjRecog.",
    .class_id = tims::class_id::kObjRecog,
    .parameters = kParameters,
};

class ObjRecogRelayLadar final : public DataModule<ObjRecogData> {
 public:
  ObjRecogRelayLadar() : DataModule(kInfo, {.history = 10}) {}

 private:
  Result<void> module_init() override {
    pushed_.set_body_max(static_cast<std::uint32_t>(integer("maxDataSize")));
    return {};
  }

  Result<void> module_on() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    offset_x_ = integer("ladarOffsetX");
    offset_y_ = integer("ladarOffsetY");
    if (auto on = position_.turn_on(); !on) return on;
    return DataModule::module_on();
  }

  Result<void> module_loop() override {
    ObjRecogData& data = get_local_buffer();
    if (auto come = next(data); !come) return come;
    if (position_) {
      const auto position = position_->get_data(data.recordingTime);
      if (!position) return position.error();
      data.refPos = position->pos;
      data.varRefPos = {};
    }
    for (ObjRecogObject& object : data.objects) {
      object.pos.x = object.pos.x.raw() + offset_x_;
      object.pos.y = object.pos.y.raw() + offset_y_;
    }
    return put_local_buffer();
  }

  // Waits for at most two periods.
  Result<void> next(ObjRecogData& data) {
    const tims::Time end = now() + 2 * period();
    for (;;) {
      const auto message = pushed_->peek_for(std::max(end - now(), tims::Duration(0)));
      if (!message) {
        const auto ms = std::to_string((2 * period()).count());
        return tims::Error(message.error().code(), "no ladar has sent objects for " + ms + " ms");
      }
      if (message->header().type != tims::type::kData) continue;
      return decode({message->header(), message->body()}, data);
    }
  }

  // This must be the first mailbox: ladars send to its fixed local id.
  OwnMailbox pushed_{*this, 2, kLargest};
  OwnMailbox work_{*this, 1, wire_size<PositionData>()};
  Partner<PositionProxy> position_{*this, "position", work_};
  std::int32_t offset_x_ = 0;
  std::int32_t offset_y_ = 0;
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::ObjRecogRelayLadar relay;
  return relay.run(argc, argv);
}
