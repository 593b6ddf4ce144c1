// Position: the pose of the robot in the world.
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
    partner("odometry", "the odometry"),
    {"startDeviation", PositionTracker::kUnknown,
     "standard deviation of the origin, at which it starts [mm]; 0: the start is the origin", 0,
     1e6},
    {"updateInterpol", 0, "blending time of an update [ms]", 0, 3600000},
    {"offsetLatitude", 0.0F, "latitude of x = 0 [deg]", -90, 90},
    {"offsetLongitude", 0.0F, "longitude of y = 0 [deg]", -180, 180},
    {"scaleLatitude", 0, "length of a degree of latitude [m]", 0, 1e6},
    {"scaleLongitude", 0, "length of a degree of longitude [m]", 0, 1e6},
    {"offsetNorthing", 0, "northing of x = 0 [m]"},
    {"offsetEasting", 0, "easting of y = 0 [m]"},
    {"utmZone", 32, "UTM zone of the world", 1, 60},
    {"utmBand", 18, "UTM band of the world: index into ABCDEFGHJKLMNPQRSTUVWXYZ", 0, 23},
    one_of("0 WGS84, 1 Gauss-Krueger, 2 UTM", {"positionReference", 0, "meaning of x and y", 0, 2}),
    {"autoOffset", 0,
     "1: the first converted place becomes the offset, rounded to 100 m, with its zone and band", 0,
     1},
    {"odometryStdDevX", 50, "growth of the standard deviation along x [mm/m]", 0, 1e6},
    {"odometryStdDevY", 50, "growth of the standard deviation along y [mm/m]", 0, 1e6},
    {"odometryStdDevRho", 0.0F, "not used, as in the original"},
}};

constexpr ModuleInfo kInfo{
    .program = "Position",
    .purpose = "Position in the world: the last known pose plus the odometry since.",
    .class_id = tims::class_id::kPosition,
    .parameters = kParameters,
    .command_slots = 8,
};

// Data sets that can be requested, or updated, by their time.
constexpr std::uint32_t kHistory = 1000;

class Position : public DataModule<PositionData> {
 public:
  Position() : DataModule(kInfo, {.history = kHistory}) {}

 private:
  Result<void> module_on() override {
    if (auto subscribed = subscribe(); !subscribed) return subscribed;
    return DataModule::module_on();
  }

  // Nothing is locked while the odometry is asked: commands are answered meanwhile.
  Result<void> subscribe() {
    const Drift drift{static_cast<double>(integer("odometryStdDevX")),
                      static_cast<double>(integer("odometryStdDevY"))};
    {
      const std::lock_guard lock(state_mutex_);
      coordinates_.emplace(coordinate_settings(), integer("autoOffset") != 0);
    }
    if (auto on = odometry_.turn_on(); !on) return on;
    const auto first = odometry_->get_data();
    if (!first) return first.error();
    {
      const std::lock_guard lock(state_mutex_);
      tracker_.expect(integer("startDeviation"));
      tracker_.begin(drift, std::chrono::milliseconds(integer("updateInterpol")), *first);
      received_.clear();
      if (auto kept = keep(*first); !kept) return kept;
    }
    const auto granted = odometry_.subscribe();
    if (!granted) return granted.error();
    set_period(*granted);
    return {};
  }

  void module_off() override {
    odometry_.stop();
    const std::lock_guard lock(state_mutex_);
    received_.clear();
  }

  Result<void> module_loop() override {
    OdometryData odometry;
    if (auto come = odometry_.next(odometry, patience_with(period())); !come) return come;
    {
      const std::lock_guard lock(state_mutex_);
      if (auto kept = keep(odometry); !kept) return kept;
      get_local_buffer() = tracker_.follow(odometry);
    }
    return put_local_buffer();
  }

  Result<void> keep(const OdometryData& odometry) {
    const auto size = encode(odometry, received_.workspace());
    if (!size) return size.error();
    received_.publish(odometry.recordingTime, *size);
    return {};
  }

  // The odometry of that time, of the data sets received; 0: the newest.
  [[nodiscard]] Result<OdometryData> odometry_at(TimeStamp time, std::chrono::milliseconds ahead) {
    if (received_.size() == 0) return refused("the position has no odometry; turn it on first");
    if (time.raw() == 0) return decode<OdometryData>(received_.newest().body);
    const auto found = received_.around(time, ahead);
    if (const auto* miss = std::get_if<DataHistory::Miss>(&found)) return not_there(*miss, time);
    const auto& pair = std::get<DataHistory::Pair>(found);
    const auto before = decode<OdometryData>(pair.before.body);
    if (!before) return before;
    const auto after = decode<OdometryData>(pair.after.body);
    if (!after) return after;
    return interpolated(*before, *after, time);
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
    if (!is_on()) return refused("the position is off and has no odometry; turn it on first");
    const auto ahead = 2 * period();  // the newest odometry may be on its way
    {
      const std::lock_guard lock(state_mutex_);
      const auto then = odometry_at(known->recordingTime, ahead);
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
    report_offset(before, coordinates().settings());
    reply(message.header, PositionType::kPos, *position);
    return {};
  }

  // Logs the offset found by autoOffset.
  void report_offset(const CoordinateSettings& before, const CoordinateSettings& now) {
    const auto report = [this](std::string_view name, i32 was, i32 is) {
      if (is != was) set_parameter(name, is);
    };
    report("offsetNorthing", before.offset_northing, now.offset_northing);
    report("offsetEasting", before.offset_easting, now.offset_easting);
    report("utmZone", before.utm_zone, now.utm_zone);
    report("utmBand", before.utm_band, now.utm_band);
  }

  template <typename To>
  Result<void> from_position(const tims::MessageView& message, i8 type,
                             Result<To> (Coordinates::*convert)(const PositionData&) const) {
    const auto position = decode<PositionData>(message);
    if (!position) return position.error();
    const std::lock_guard lock(state_mutex_);
    const auto place = (coordinates().*convert)(*position);
    if (!place) return place.error();
    reply(message.header, type, *place);
    return {};
  }

  // Also available before the first ON.
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

  OwnMailbox work_{*this, 1, 128};
  Input<OdometryProxy> odometry_{*this, "odometry", work_, 4, wire_size<OdometryData>()};
  PriorityMutex state_mutex_;  // protects the members below
  DataHistory received_{kHistory, wire_size<OdometryData>()};
  PositionTracker tracker_{{}, {}};  // kept while off: the pose stays
  std::optional<Coordinates> coordinates_;
};

}  // namespace
}  // namespace rack::navigation

int main(int argc, char** argv) {
  rack::navigation::Position position;
  return position.run(argc, argv);
}
