// LadarIbeoLux: driver of an Ibeo Lux on the network. It publishes the points and sends recognised
// objects to up to two ObjRecogRelayLadar: bounding boxes to one, contours to the other.
#include "components/devices/scanners/ibeo_lux.h"
#include "rack/devices/driver.h"
#include "rack/partner.h"
#include "rack/proxies/position.h"

namespace rack::device {
namespace {

constexpr std::int32_t kPort = 12002;

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 7>{{
    {"ladarIp", "", "host name or IP address of the scanner; not needed with device="},
    {"ladarPort", kPort, "TCP port of the scanner", 1, 65535},
    optional_partner("position", "the position", "the position, for refPos of objects; -1: none"),
    optional_partner("objRecogBound", "the relay for boxes", "the relay for boxes; -1: none"),
    optional_partner("objRecogContour", "the relay for contours",
                     "the relay for contours; -1: none"),
    {"distanceFilter", 0, "1: keep only the nearest object at each angle of a layer", 0, 1},
    one_of("0 relative to the scanner, 1 over ground",
           {"velocityMode", 0, "velocity of objects", 0, 1}),
}});

constexpr ModuleInfo kInfo{
    .program = "LadarIbeoLux",
    .purpose = "An Ibeo Lux laser range finder on the network.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarIbeoLux final : public Driver<LadarData, IbeoLux> {
 public:
  LadarIbeoLux() : Driver(kInfo, {.history = 10}) {
    reserve_all(boxes_);
    reserve_all(contours_);
    bytes_.resize(body_max<ObjRecogData>());
  }

 private:
  Result<DeviceOptions> device() const override {
    DeviceOptions options{.baud = 0, .record = text("record")};
    std::string address = text("device");
    if (address.empty()) {
      if (text("ladarIp").empty()) return refused("ladarIp or device must be set");
      address = "tcp:" + text("ladarIp") + ":" + std::to_string(integer("ladarPort"));
    }
    const auto parsed = DeviceAddress::parse(address);
    if (!parsed) return parsed.error();
    options.address = *parsed;
    return options;
  }

  Result<std::unique_ptr<IbeoLux>> make_dialogue() override {
    set_period(std::chrono::milliseconds(80));
    return std::make_unique<IbeoLux>(
        IbeoLuxSettings{.only_nearest = integer("distanceFilter") != 0,
                        .absolute_speeds = integer("velocityMode") != 0});
  }

  Result<void> module_on() override {
    if (auto on = turn_on(box_relay_); !on) return on;
    if (auto on = turn_on(contour_relay_); !on) return on;
    if (auto on = position_.turn_on(); !on) return on;
    return Driver::module_on();
  }

  void module_off() override {
    for (auto* const relay : {&box_relay_, &contour_relay_}) {
      if (*relay) (void)(*relay)->off();
      relay->disconnect();
    }
    Driver::module_off();
  }

  // A relay can only be turned on after it has received data: sends an empty list first.
  Result<void> turn_on(Partner<ObjRecogProxy>& relay) {
    relay.connect();
    if (!relay) return {};
    ObjRecogData nothing;
    nothing.recordingTime = time_stamp();
    send(*relay, nothing);
    return relay->on();
  }

  // Sends to the first mailbox of the relay, as in the original. If the relay is not running, the
  // message is lost.
  void send(const ObjRecogProxy& relay, const ObjRecogData& objects) {
    const auto size = encode(objects, bytes_);
    if (!size) return;
    auto fields = relay.component().fields(address_widths());
    fields.local = 1;
    const tims::Envelope envelope{.dest = tims::Address::of(fields, address_widths()),
                                  .type = tims::type::kData,
                                  .stream = true};
    (void)work_->send(envelope, std::span<const std::byte>(bytes_).first(*size));
  }

  // Objects are sent together with the scan from which they were derived.
  Result<void> complete(LadarData&) override {
    tims::Time recorded{};
    if (!dialogue().take_objects(boxes_, contours_, recorded)) return {};
    for (ObjRecogData* const objects : {&boxes_, &contours_}) {
      objects->recordingTime = time_stamp_of(recorded);
      if (!position_) continue;
      const auto position = position_->get_data(objects->recordingTime);
      if (!position) return position.error();
      objects->refPos = position->pos;
      objects->varRefPos = position->var;
    }
    if (box_relay_) send(*box_relay_, boxes_);
    if (contour_relay_) send(*contour_relay_, contours_);
    return {};
  }

  OwnMailbox work_{*this, 10, wire_size<PositionData>()};
  Partner<ObjRecogProxy> box_relay_{*this, "objRecogBound", work_};
  Partner<ObjRecogProxy> contour_relay_{*this, "objRecogContour", work_};
  Partner<PositionProxy> position_{*this, "position", work_};
  ObjRecogData boxes_;
  ObjRecogData contours_;
  std::vector<std::byte> bytes_;
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::LadarIbeoLux ladar;
  return ladar.run(argc, argv);
}
