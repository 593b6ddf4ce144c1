// MonteCarloLocalisation: the pose of the robot in a map, by its laser scanner.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "components/files/file_folder.h"
#include "components/localisation/heading_search.h"
#include "components/localisation/mcl_messages.h"
#include "components/localisation/position_updates.h"
#include "components/position/map_file.h"
#include "components/position/map_parameters.h"
#include "rack/data_module.h"
#include "rack/data_of_time.h"
#include "rack/input.h"
#include "rack/proxies/odometry.h"
#include "tims/origin.h"

namespace rack::navigation {
namespace {

using localisation::LikelihoodField;
using localisation::Localiser;
using localisation::WallLines;

constexpr std::array<ParameterInfo, 22> kParameters = {{
    partner("scan2d", "the scan"),
    partner("odometry", "the odometry"),
    optional_partner("position", "the position", "the position to update; -1: none"),
    {"period", 1000, "period of the data and of updates of the position [ms]", 1, 60000},
    host_file({"mapFile", "",
               "floor plan (DXF) or map of ROS (.yaml); empty: the map comes by LOAD_MAP"}),
    kMapScaleFactor,
    kMapOffsetX,
    kMapOffsetY,
    kMapLayers,
    kMapResolution,
    {"particles", 500, "number of particles while localised", 10, 100000},
    {"particlesMax", 20000, "number of particles while searching", 10, 100000},
    {"beams", 60, "number of beams used per scan", 1, 8000},
    {"scanMatching", 1, "1: refine the pose by matching scans against the walls of the map", 0, 1},
    {"maxRange", 30000, "maximum range of the scanner [mm]", 1, 1e9},
    {"scanLag", 0, "delay of the time stamps of scans [ms]", 0, 1000},
    one_of("0 startX ..., 1 unknown, 2 from the position, 3 from the position once that is known",
           {"startMode", 0, "start pose", 0, 3}),
    {"startX", 0, "start pose, to the north [mm]"},
    {"startY", 0, "start pose, to the east [mm]"},
    {"startRho", 0, "heading of the start pose [deg]", -360, 360},
    {"startDeviation", 500,
     "standard deviation of the start pose [mm]; of its heading 0.03 deg per mm", 0, 100000},
    {"seed", 1, "seed of the random generator", 0, 2147483647.0},
}};

constexpr ModuleInfo kInfo{
    .program = "MonteCarloLocalisation",
    .purpose = "Determines the pose of the robot in a map by its laser scanner.",
    .class_id = tims::class_id::kMcl,
    .parameters = kParameters,
};

constexpr int kMissesMax = 20;          // scans in a row without odometry of their time
constexpr int kUpdatesMissedMost = 10;  // in a row
// How long odometry and position of the time of a scan are waited for.
constexpr std::chrono::milliseconds kLate{300};
constexpr double kDeviationTurn = radians(0.03);  // per mm
constexpr double kUnknownTurn = radians(45.0);
constexpr double kFoundDeviation = 300;  // mm, of a pose that was found by the map

class MonteCarloLocalisation : public DataModule<MclData> {
 public:
  MonteCarloLocalisation() : DataModule(kInfo, {.history = 10}) {
    reserve_all(scan_);
    beams_.reserve(decltype(scan_.points)::kMax);
  }

 private:
  Result<void> module_on() override {
    if (auto map = ensure_map(); !map) return map;
    lag_ = std::chrono::milliseconds(integer("scanLag"));
    range_max_ = integer("maxRange");
    matches_scans_ = integer("scanMatching") != 0;
    misses_ = 0;
    updates_missed_ = 0;
    published_.reset();
    updates_ = {};
    odometry_then_ = {};
    position_then_ = {};
    if (auto on = odometry_.turn_on(); !on) return on;
    if (auto on = position_.turn_on(); !on) return on;
    make_localiser();
    if (auto started = start(); !started) return started;
    const auto granted = scan2d_.start();
    if (!granted) return granted.error();
    scan_period_ = *granted;
    data_period_ = std::chrono::milliseconds(integer("period"));
    set_period(std::max(data_period_, scan_period_));
    return DataModule::module_on();
  }

  void module_off() override { scan2d_.stop(); }

  // A map from LOAD_MAP is kept when the component is turned off and on.
  Result<void> ensure_map() {
    {
      const std::lock_guard lock(field_mutex_);
      if (commanded_) return {};
    }
    const std::string path = text("mapFile");
    if (path.empty()) return refused("no map: mapFile is empty, and no LOAD_MAP was received");
    return take_map(path, false);
  }

  [[nodiscard]] PlanPlacement placement() const {
    return {.scale = static_cast<double>(integer("mapScaleFactor")),
            .offset_x = static_cast<double>(integer("mapOffsetX")),
            .offset_y = static_cast<double>(integer("mapOffsetY")),
            .layers = text("mapLayers")};
  }

  // Any task. Reading may take long; only the exchange of the map is locked.
  Result<void> take_map(const std::string& path, bool commanded) {
    const auto loaded = load_map(path, placement(), integer("mapResolution"));
    if (!loaded) return loaded.error();
    for (const std::string& remark : loaded->remarks) log().warning("{}", remark);
    const localisation::GridMap& map = loaded->map;
    auto made = LikelihoodField::of(map, {});
    if (!made) return tims::Error(made.error().code(), path + ": " + made.error().detail());
    auto field = std::make_unique<LikelihoodField>(std::move(made).value());
    auto walls = std::make_unique<WallLines>(map);
    log().info("map {}: {} x {} cells of {} mm, {} free", path, map.rows, map.columns,
               map.resolution, field->free_cells());
    const std::lock_guard lock(field_mutex_);
    field_.swap(field);
    walls_.swap(walls);
    commanded_ = commanded_ || commanded;
    return {};
  }

  void make_localiser() {
    localisation::LocaliserSettings settings;
    settings.filter.particles = static_cast<std::uint32_t>(integer("particles"));
    settings.filter.particles_max =
        std::max(settings.filter.particles, static_cast<std::uint32_t>(integer("particlesMax")));
    settings.beams = static_cast<std::uint32_t>(integer("beams"));
    localiser_.emplace(settings, static_cast<std::uint64_t>(integer("seed")));
  }

  Result<void> start() {
    const int mode = integer("startMode");
    waits_ = false;
    if (mode == 1) {
      localiser_->start_anywhere();
      return {};
    }
    if (mode >= 2 && !position_) return refused("startMode 2 and 3 need positionInst");
    waits_ = mode >= 2;
    reported_waiting_ = false;
    if (waits_) return {};
    const Pose at{.x = static_cast<double>(integer("startX")),
                  .y = static_cast<double>(integer("startY")),
                  .rho = heading(radians(integer("startRho")))};
    const auto deviation = static_cast<double>(integer("startDeviation"));
    localiser_->start_at(at, deviation, deviation * kDeviationTurn);
    return {};
  }

  // Around the position by its own deviation. After the first fix of satellites the place is known,
  // but no heading: the scan and the map show it.
  void start_at_known(const PositionData& known, double deviation) {
    const Pose at = Pose::of(known.pos);
    double turn = std::max<double>(integer("startDeviation") * kDeviationTurn, known.var.rho);
    if (known.var.rho > kUnknownTurn) {
      const auto found = localisation::find_heading(*field_, beams_, at, deviation);
      const bool is_clear = found && found->is_clear();
      if (found)
        log().print("Heading {:.0f} deg fits by {:.2f}, the best other one by {:.2f}{}",
                    degrees(found->pose.rho), found->fit, found->rival_fit,
                    is_clear ? "" : ": not clear");
      if (is_clear) {
        localiser_->start_at(found->pose, kFoundDeviation, kFoundDeviation * kDeviationTurn);
        return;
      }
      turn = kPi;
    }
    localiser_->start_at(at, deviation, turn);
  }

  void start_as_it_is(const PositionData& position, double deviation) {
    const double turn = deviation * kDeviationTurn;
    if (localisation::PositionUpdates::may_start_at(position, odometry_pose_, deviation, turn)) {
      localiser_->start_at(Pose::of(position.pos), deviation, turn);
      return;
    }
    log().warning(
        "Position does not know where the robot is, and it has moved: searching for it "
        "in the whole map");
    localiser_->start_anywhere();
  }

  // With startMode 2 and 3: where Position was at the time of the first scan, as the robot may be
  // moving. Meanwhile the data have no particles.
  Result<void> start_from_position(TimeStamp time) {
    if (!is_due()) return {};
    PositionData known;
    if (auto come = position_then_.get(*position_, known, time, kLate); !come) {
      if (++misses_ > kMissesMax) return come;
      return {};
    }
    misses_ = 0;
    const double at_least = integer("startDeviation");
    const double deviation = std::max({1.0 * known.var.x.raw(), 1.0 * known.var.y.raw(), at_least});
    const bool as_it_is = integer("startMode") == 2;
    waits_ = !as_it_is && deviation > localisation::PositionUpdates::kKnown;
    if (!waits_) {
      const std::lock_guard lock(field_mutex_);
      if (as_it_is)
        start_as_it_is(known, at_least);
      else
        start_at_known(known, deviation);
      return {};
    }
    if (!std::exchange(reported_waiting_, true))
      log().print("The position is not known yet: waiting for its first update");
    MclData& data = get_local_buffer();
    data.recordingTime = time;
    data.pos = {};
    data.points.clear();  // keeps its memory
    return put_local_buffer();
  }

  Result<void> module_loop() override {
    if (auto come = scan2d_.next(scan_, patience_with(scan_period_)); !come) return come;
    const TimeStamp time = scan_.recordingTime - lag_;
    OdometryData odometry;
    if (auto come = odometry_then_.get(*odometry_, odometry, time, kLate); !come) {
      // The odometry may be late or may have just started.
      if (++misses_ > kMissesMax) return come;
      return {};
    }
    misses_ = 0;
    odometry_pose_ = Pose::of(odometry.pos);
    localisation::beams_of(scan_, range_max_, beams_);
    if (waits_) {
      if (auto started = start_from_position(time); !started || waits_) return started;
    }
    {
      const std::lock_guard lock(field_mutex_);
      localiser_->take(*field_, odometry_pose_, beams_, matches_scans_ ? walls_.get() : nullptr);
    }
    if (!is_due()) return {};
    return publish_estimate(time);
  }

  // Once per period on average.
  bool is_due() {
    if (published_ && scan_.recordingTime - *published_ < data_period_) return false;
    const bool follows = published_ && scan_.recordingTime - *published_ < 2 * data_period_;
    published_ = follows ? *published_ + data_period_ : scan_.recordingTime;
    return true;
  }

  Result<void> publish_estimate(TimeStamp time) {
    if (position_)
      if (auto done = update_position(time); !done) return done;
    localisation::to_message(*localiser_, time, get_local_buffer());
    return put_local_buffer();
  }

  Result<void> update_position(TimeStamp time) {
    using Event = localisation::PositionUpdates::Event;
    std::optional<PositionData> believed;  // stays empty when it is late
    PositionData data;
    if (position_then_.get(*position_, data, time, kLate)) believed = data;
    const auto step =
        updates_.take(*localiser_, odometry_pose_, believed, time,
                      [this](TimeStamp earlier) { return position_->get_data(earlier).ok(); });
    if (step.event == Event::kFollows)
      log().print("The position was updated, {:.1f} m from here: searching there",
                  step.away / 1000);
    else if (step.event != Event::kNone)
      log().print("The pose is {}", step.event == Event::kCertain ? "certain" : "uncertain");
    if (!step.update) return {};
    auto updated = position_->update(*step.update);
    // A Position that is being restarted has forgotten where the robot is: this localiser has not.
    if (!updated && ++updates_missed_ <= kUpdatesMissedMost) return {};
    updates_missed_ = 0;
    return updated;
  }

  Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != MclType::kLoadMap) return DataModule::module_command(message);
    const auto file = decode<FileName>(message);
    if (!file) return file.error();
    return answered_later(message, [this, name = std::string(file->view()),
                                    is_foreign = tims::is_foreign(message.header)] {
      return load(name, is_foreign);
    });
  }

  Result<void> load(std::string_view name, bool is_foreign) {
    const auto path = file_to_read(name, is_foreign);
    if (!path) return path.error();
    auto taken = take_map(*path, true);
    if (taken) set_parameter("mapFile", *path);
    return taken;
  }

  OwnMailbox work_{*this, 1, body_max<PositionData>()};
  Input<Scan2dProxy> scan2d_{*this, "scan2d", work_, 2, body_max<Scan2dData>()};
  Partner<OdometryProxy> odometry_{*this, "odometry", work_};
  Partner<PositionProxy> position_{*this, "position", work_};
  DataOfTime<OdometryProxy> odometry_then_;
  DataOfTime<PositionProxy> position_then_;
  std::optional<Localiser> localiser_;
  Scan2dData scan_;
  std::vector<localisation::BeamEnd> beams_;
  std::chrono::milliseconds scan_period_{};
  std::chrono::milliseconds data_period_{};
  std::chrono::milliseconds lag_{};
  i32 range_max_ = 0;
  bool matches_scans_ = true;
  int misses_ = 0;
  int updates_missed_ = 0;
  std::optional<TimeStamp> published_;
  Pose odometry_pose_{};  // at the last scan
  localisation::PositionUpdates updates_;
  PriorityMutex field_mutex_;  // protects the three members below, which LOAD_MAP exchanges
  std::unique_ptr<LikelihoodField> field_;
  std::unique_ptr<WallLines> walls_;
  bool commanded_ = false;
  bool waits_ = false;  // for a known position
  bool reported_waiting_ = false;
};

}  // namespace
}  // namespace rack::navigation

int main(int argc, char** argv) {
  rack::navigation::MonteCarloLocalisation localisation;
  return localisation.run(argc, argv);
}
