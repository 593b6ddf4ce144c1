// Position: where the robot is in the world.
#include <array>
#include <mutex>
#include <optional>

#include "components/geometry/coordinates.h"
#include "components/position/reckoning.h"
#include "rack/data_module.h"
#include "rack/input.h"

namespace rack::navigation {
namespace {

constexpr std::array<ParameterInfo, 16> kParameters = {{
    {"odometrySys", 0, "system id of the odometry", 0, kIdMax},
    {"odometryInst", 0, "instance of the odometry", 0, kIdMax},
    {"updateInterpol", 0, "time an update takes to have its full effect, ms", 0, 3600000},
    {"offsetLatitude", 0.0F, "of x = 0, deg", -90, 90},
    {"offsetLongitude", 0.0F, "of y = 0, deg", -180, 180},
    {"scaleLatitude", 0, "length of a degree of latitude, m", 0, 1e6},
    {"scaleLongitude", 0, "length of a degree of longitude, m", 0, 1e6},
    {"offsetNorthing", 0, "of x = 0, m"},
    {"offsetEasting", 0, "of y = 0, m"},
    {"utmZone", 32, "of the world", 1, 60},
    {"utmBand", 18, "of the world: index into ABCDEFGHJKLMNPQRSTUVWXYZ", 0, 23},
    {"positionReference", 0, "what x and y are: 0 WGS84, 1 Gauss-Krueger, 2 UTM", 0, 2},
    {"autoOffset", 0,
     "1: the first place that is converted becomes the offset, to 100 m, with its zone and band", 0,
     1},
    {"odometryStdDevX", 50, "how uncertain a way along x is, mm/m", 0, 1e6},
    {"odometryStdDevY", 50, "and one along y, mm/m", 0, 1e6},
    {"odometryStdDevRho", 0.0F, "not used, as in the original"},
}};

constexpr ModuleInfo kInfo{
    .program = "Position",
    .purpose = "Position in the world: what was known once, and the odometry since.",
    .class_id = tims::class_id::kPosition,
    .parameters = kParameters,
    .command_slots = 8,
};

class Position : public DataModule<PositionData> {
 public:
  Position() : DataModule(kInfo, {.history = 1000}) {}

 private:
  Result<void> module_init() override {
    const auto work = create_mailbox(1, 128);
    if (!work) return work.error();
    return create_input(odometry_, **work, 4, wire_size<OdometryData>());
  }

  Result<void> module_on() override {
    if (auto subscribed = subscribe(); !subscribed) return subscribed;
    return DataModule::module_on();
  }

  Result<void> subscribe() {
    const std::lock_guard lock(state_mutex_);
    const Drift drift{static_cast<double>(integer("odometryStdDevX")),
                      static_cast<double>(integer("odometryStdDevY"))};
    coordinates_.emplace(coordinate_settings(), integer("autoOffset") != 0);
    if (auto on = odometry_->turn_on(address_of(tims::class_id::kOdometry, "odometry")); !on)
      return on;
    const auto first = odometry_->proxy().get_data();
    if (!first) return first.error();
    tracker_.begin(drift, std::chrono::milliseconds(integer("updateInterpol")), *first);
    const auto granted = odometry_->subscribe();
    if (!granted) return granted.error();
    set_period(*granted);
    return {};
  }

  void module_off() override {
    const std::lock_guard lock(state_mutex_);
    odometry_->stop();
  }

  Result<void> module_loop() override {
    OdometryData odometry;
    if (auto come = odometry_->next(odometry, 5 * period()); !come) return come;
    {
      const std::lock_guard lock(state_mutex_);
      get_local_buffer() = tracker_.follow(odometry);
    }
    return put_local_buffer();
  }

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case PositionType::kUpdate:
        return update(message);
      case PositionType::kWgs84ToPos:
        return to_position<PositionWgs84Data>(message);
      case PositionType::kGkToPos:
        return to_position<PositionGkData>(message);
      case PositionType::kUtmToPos:
        return to_position<PositionUtmData>(message);
      case PositionType::kPosToWgs84:
        return from_position(message, PositionType::kWgs84, &Coordinates::to_wgs84);
      case PositionType::kPosToGk:
        return from_position(message, PositionType::kGk, &Coordinates::to_gk);
      case PositionType::kPosToUtm:
        return from_position(message, PositionType::kUtm, &Coordinates::to_utm);
      default:
        return DataModule::module_command(message);
    }
  }

  Result<std::size_t> data_at(TimeStamp time, std::span<std::byte> to) const override {
    return data_between(time, to, interpolated);
  }

  Result<void> update(const tims::MessageView& message) {
    const auto known = decode<PositionData>(message);
    if (!known) return known.error();
    if (!is_on()) return refused("there is no odometry while off");
    {
      const std::lock_guard lock(state_mutex_);
      if (!odometry_->started()) return refused("just turned off");
      const auto then = odometry_->proxy().get_data(known->recordingTime);
      if (!then) return then.error();
      tracker_.update(*known, *then);
    }
    reply(message.header, tims::type::kOk);
    return {};
  }

  template <typename From>
  Result<void> to_position(const tims::MessageView& message) {
    const auto from = decode<From>(message);
    if (!from) return from.error();
    const std::lock_guard lock(state_mutex_);
    const CoordinateSettings before = coordinates().settings();
    auto position = coordinates().from(*from);
    if (!position) return position.error();
    tell_found(before, coordinates().settings());
    reply(message.header, PositionType::kPos, *position);
    return {};
  }

  // What autoOffset has found.
  void tell_found(const CoordinateSettings& before, const CoordinateSettings& now) {
    const auto tell = [this](std::string_view name, i32 was, i32 is) {
      if (is != was) set_parameter(name, is);
    };
    tell("offsetNorthing", before.offset_northing, now.offset_northing);
    tell("offsetEasting", before.offset_easting, now.offset_easting);
    tell("utmZone", before.utm_zone, now.utm_zone);
    tell("utmBand", before.utm_band, now.utm_band);
  }

  template <typename To>
  Result<void> from_position(const tims::MessageView& message, i8 type,
                             To (Coordinates::*convert)(const PositionData&) const) {
    const auto position = decode<PositionData>(message);
    if (!position) return position.error();
    const std::lock_guard lock(state_mutex_);
    reply(message.header, type, (coordinates().*convert)(*position));
    return {};
  }

  // Also before it was ever on.
  Coordinates& coordinates() {
    if (!coordinates_) coordinates_.emplace(coordinate_settings(), integer("autoOffset") != 0);
    return *coordinates_;
  }

  [[nodiscard]] CoordinateSettings coordinate_settings() const {
    return {.reference = static_cast<PositionReference>(integer("positionReference")),
            .offset_latitude = real("offsetLatitude"),
            .offset_longitude = real("offsetLongitude"),
            .scale_latitude = static_cast<double>(integer("scaleLatitude")),
            .scale_longitude = static_cast<double>(integer("scaleLongitude")),
            .offset_northing = integer("offsetNorthing"),
            .offset_easting = integer("offsetEasting"),
            .utm_zone = integer("utmZone"),
            .utm_band = integer("utmBand")};
  }

  std::optional<Input<OdometryProxy>> odometry_;
  // Of what follows, and of the work mailbox: an update asks the odometry, too.
  PriorityMutex state_mutex_;
  PositionTracker tracker_{{}, {}};  // also while it is off: it is where it was
  std::optional<Coordinates> coordinates_;
};

}  // namespace
}  // namespace rack::navigation

int main(int argc, char** argv) {
  rack::navigation::Position position;
  return position.run(argc, argv);
}
