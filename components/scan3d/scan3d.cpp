// Scan3d: 3D scans from a ladar on an axis that tilts or turns it.
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>

#include "components/geometry/pose.h"
#include "components/scan3d/scan3d_commands.h"
#include "components/scan3d/sweep.h"
#include "rack/input.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/position.h"
#include "rack/proxies/servo_drive.h"

namespace rack::scan3d {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSilence{200};  // without scans of the ladar; at least five of its periods
constexpr milliseconds kResend{500};   // period of repeated commands to the axis
constexpr double kThere = radians(1);  // distance to the end where the axis turns back
constexpr std::uint32_t kLadarSlots = 16;  // scans that are queued while a message is built

constexpr std::array<ParameterInfo, 32> kParameters = {{
    required_partner("ladar", "the ladar"),
    required_partner("servoDrive", "the axis"),
    optional_partner("position", "the position",
                     "the position, for refPos and the robot's movement; -1: none"),
    optional_partner(
        "odometry", "the odometry",
        "the odometry, for the movement instead of the position, which may jump; -1: none"),
    one_of("1 roll (about x), 2 pitch (about y), 3 yaw, 4 top, 5 top-down",
           {"scanMode", 2,
            "motion of the axis; yaw, top and top-down: about z, the ladar upright, its front "
            "ahead, up, down",
            1, 5}),
    {"angleMin", -45.0F, "lower limit of the axis [deg]", -1e5, 1e5},
    {"angleMax", 45.0F, "upper limit of the axis [deg]", -1e5, 1e5},
    {"round", 0, "1: turn continuously, each angleMax - angleMin is a scan; 0: to and fro", 0, 1},
    {"drive", 1, "1: move the axis; 0: another program moves it", 0, 1},
    {"axisVel", 20.0F, "speed of the axis [deg/s]; below 0: turn in the other direction", -720,
     720},
    {"sectors", 8,
     "number of partial messages per scan, in addition to the whole; 1: only the whole", 1, 64},
    {"scanNum", 400, "maximum number of flat scans in a whole scan", 1, 10000},
    {"maxPoints", 72400,
     "maximum number of points in a whole scan; more points per flat scan mean fewer flat scans", 1,
     static_cast<double>(kScan3dPointsMax)},
    {"reduce", 1, "use every n-th point", 1, 10000},
    {"minRange", 0, "nearer points are the robot itself [mm]", 0, 1e6},
    {"maxRange", 0, "farther points are ignored [mm]; 0: range of the ladar", 0, 1e6},
    {"axisX", 0, "position of the axis on the robot, forward [mm]"},
    {"axisY", 0, "the same to the right [mm]"},
    {"axisZ", 0, "the same downwards [mm]"},
    {"axisPhi", 0.0F, "orientation of the axis about x [deg]", -360, 360},
    {"axisPsi", 0.0F, "the same about y [deg]", -360, 360},
    {"axisRho", 0.0F, "the same about z [deg]", -360, 360},
    {"ladarX", 0, "position of the ladar relative to the axis at angle 0, forward [mm]"},
    {"ladarY", 0, "the same to the right [mm]"},
    {"ladarZ", 0, "the same downwards [mm]"},
    {"ladarRho", 0.0F, "orientation of the ladar in its plane, clockwise [deg]", -360, 360},
    {"ladarUpsideDown", 0, "1: the ladar is mounted upside down", 0, 1},
    {"ladarReversed", 0, "1: the last point is measured first (SICK LMS200, S300)", 0, 1},
    {"ladarLag", 0.0F, "delay of the time stamps of the ladar [ms]", -1000, 1000},
    {"ladarDuration", -1.0F,
     "duration of a flat scan [ms]; -1: as reported by the ladar; LadarSim: 0", -1, 1000},
    {"compress", 0, "1: compress the points", 0, 1},
    kStorePath,
}};

constexpr ModuleInfo kInfo{
    .program = "Scan3d",
    .purpose = "3D scans from a ladar on an axis that tilts or turns it.",
    .class_id = tims::class_id::kScan3d,
    .parameters = kParameters,
};

class Scan3d : public Scan3dCommands<DataModule<Scan3dData>> {
 public:
  Scan3d() : Scan3dCommands(kInfo, {.history = 4}) {
    reserve_all(ladar_data_);
    reserve_all(whole_);
  }

 private:
  Result<void> module_on() override {
    const SweepSettings settings = sweep_settings();
    if (!(settings.to > settings.from)) return refused("angleMax is not larger than angleMin");
    velocity_ = radians(static_cast<double>(real("axisVel")));
    if (velocity_ == 0) return refused("axisVel=0: the axis would never move");
    if (velocity_ < 0 && !settings.is_round) return refused("axisVel below 0 needs round=1");
    sweep_ = std::make_unique<Sweep>(settings);
    commanded_ = {};
    reported_losses_ = {};
    if (auto on = servo_.turn_on(); !on) return on;
    if (auto on = position_.turn_on(); !on) return on;
    if (auto on = odometry_.turn_on(); !on) return on;
    const auto granted = ladar_.start();
    if (!granted) return granted.error();
    silence_ = std::max(5 * *granted, kSilence);
    const double whole = (settings.to - settings.from) / std::abs(velocity_);  // s
    set_period(std::max(milliseconds(std::lround(1000 * whole / settings.sectors)), *granted));
    return DataModule::module_on();
  }

  [[nodiscard]] double angle(std::string_view name) const {
    return radians(static_cast<double>(real(name)));
  }
  [[nodiscard]] double number(std::string_view name) const {
    return static_cast<double>(integer(name));
  }

  [[nodiscard]] SweepMounting mounting() const {
    return {.mode = integer("scanMode"),
            .axis = {.x = number("axisX"),
                     .y = number("axisY"),
                     .z = number("axisZ"),
                     .phi = angle("axisPhi"),
                     .psi = angle("axisPsi"),
                     .rho = angle("axisRho")},
            .ladar = {number("ladarX"), number("ladarY"), number("ladarZ")},
            .ladar_rho = angle("ladarRho"),
            .upside_down = integer("ladarUpsideDown") != 0,
            .is_reversed = integer("ladarReversed") != 0};
  }
  [[nodiscard]] SweepSettings sweep_settings() const {
    return {.mounting = mounting(),
            .from = angle("angleMin"),
            .to = angle("angleMax"),
            .is_round = integer("round") != 0,
            .scans_max = static_cast<std::size_t>(integer("scanNum")),
            .points_max = static_cast<std::size_t>(integer("maxPoints")),
            .sectors = integer("sectors"),
            .reduce = static_cast<std::size_t>(integer("reduce")),
            .range_min = integer("minRange"),
            .range_max = integer("maxRange"),
            .lag_ms = static_cast<double>(real("ladarLag")),
            .duration_ms = static_cast<double>(real("ladarDuration")),
            .has_poses = position_.is_named() || odometry_.is_named()};
  }

  void module_off() override {
    ladar_.stop();
    if (servo_ && integer("drive") != 0) (void)servo_->move_vel(0);
    servo_.disconnect();
  }

  Result<void> module_loop() override {
    if (auto come = ladar_.next(ladar_data_, silence_); !come) return come;
    sweep_->add(ladar_data_);
    if (auto asked = ask(); !asked) return asked;
    if (auto moved = move_axis(); !moved) return moved;
    while (sweep_->next(get_local_buffer()))
      if (auto sent = send(); !sent) return sent;
    return {};
  }

  // Requests the current poses of axis and robot, and those at the time of the pending scan.
  Result<void> ask() {
    const auto axis = servo_->get_data();
    if (!axis) return axis.error();
    angle_ = static_cast<double>(axis->position);
    sweep_->add_axis(axis->recordingTime, angle_);
    const auto pose = newest_pose();
    if (!pose) return pose.error();
    const auto wanted = sweep_->wanted();
    if (!wanted || axis->recordingTime < wanted->end || *pose < wanted->end) return {};
    const TimeStamp middle = wanted->begin + (wanted->end - wanted->begin) / 2;
    for (const TimeStamp time : {wanted->begin, middle, wanted->end}) {
      const auto then = servo_->get_data(time);
      if (then) sweep_->add_axis(then->recordingTime, static_cast<double>(then->position));
      if (auto known = known_or_lost(then); !known) return known;
      if (auto known = ask_pose(time); !known) return known;
    }
    return {};
  }

  // The time of the newest pose; without poses of the robot it is never too old.
  Result<TimeStamp> newest_pose() {
    if (!position_ && !odometry_) return ladar_data_.recordingTime + kSilence;
    TimeStamp time = 0;
    if (auto asked = ask_pose(0, &time); !asked) return asked.error();
    return time;
  }

  Result<void> ask_pose(TimeStamp time, TimeStamp* recorded = nullptr) {
    if (odometry_) return take_pose(odometry_->get_data(time), recorded);
    if (position_) return take_pose(position_->get_data(time), recorded);
    return {};
  }
  template <typename Data>
  Result<void> take_pose(const Result<Data>& data, TimeStamp* recorded) {
    if (!data) return known_or_lost(data);
    sweep_->add_pose(data->recordingTime, data->pos);
    if (recorded != nullptr) *recorded = data->recordingTime;
    return {};
  }
  // A component without data of that time answers ERROR: only that flat scan is lost.
  template <typename Data>
  static Result<void> known_or_lost(const Result<Data>& data) {
    if (data || data.error().code() == tims::Errc::kAnsweredError) return {};
    return data.error();
  }

  // Moves to the other end when one is reached. The command is repeated, since the drive may have
  // been off.
  Result<void> move_axis() {
    if (integer("drive") == 0) return {};
    const double low = angle("angleMin");
    const double high = angle("angleMax");
    const double before = goal_;
    if (!commanded_ || (goal_ != low && goal_ != high))
      goal_ = std::abs(angle_ - low) < std::abs(angle_ - high) ? low : high;
    if (std::abs(angle_ - goal_) < kThere) goal_ = goal_ == low ? high : low;
    const bool is_round = integer("round") != 0;
    const tims::Time time = now();
    if (commanded_ && (is_round || goal_ == before) && time - *commanded_ < kResend) return {};
    commanded_ = time;
    if (is_round) return servo_->move_vel(static_cast<f32>(velocity_));
    return servo_->move_pos(
        {.position = static_cast<f32>(goal_), .vel = static_cast<f32>(velocity_)});
  }

  Result<void> send() {
    Scan3dData& scan = get_local_buffer();
    if (odometry_) {  // the frame of the odometry is only used here
      scan.refPos = {};
      if (position_) {
        const auto position = position_->get_data(scan.recordingTime);
        if (!position) return position.error();
        scan.refPos = position->pos;
      }
    }
    if (scan.sectorNum == 1) {
      report_losses();
      const std::lock_guard lock(whole_mutex_);
      whole_ = scan;
    }
    if (integer("compress") != 0) compression_.compress(scan);
    return put_local_buffer();
  }

  void report_losses() {
    const SweepLosses& losses = sweep_->losses();
    const auto reported = std::exchange(reported_losses_, losses);
    const auto lost = losses.unplaced + losses.crowded - reported.unplaced - reported.crowded;
    if (lost > 0)
      log().warning("{} flat scans dropped: the pose of axis or robot was not known in time", lost);
    if (losses.broken > reported.broken)
      log().warning("{} flat scans dropped: no points, or longer than a second",
                    losses.broken - reported.broken);
  }

  Result<Scan3dData> shown() const override {
    const std::lock_guard lock(whole_mutex_);
    if (whole_.points.empty()) return refused("there is no whole scan yet");
    return whole_;
  }

  OwnMailbox work_{*this, 1, 256};
  Input<LadarProxy> ladar_{*this, "ladar", work_, kLadarSlots, body_max<LadarData>()};
  Partner<ServoDriveProxy> servo_{*this, "servoDrive", work_};
  Partner<PositionProxy> position_{*this, "position", work_};
  Partner<OdometryProxy> odometry_{*this, "odometry", work_};
  LadarData ladar_data_;
  std::unique_ptr<Sweep> sweep_;
  SweepLosses reported_losses_{};
  Scan3dCompression compression_;
  milliseconds silence_{};
  double velocity_ = 0;  // rad/s
  double angle_ = 0;     // newest angle of the axis
  double goal_ = 0;
  std::optional<tims::Time> commanded_{};  // time of the last command to the axis
  mutable PriorityMutex whole_mutex_;
  Scan3dData whole_;
};

}  // namespace
}  // namespace rack::scan3d

int main(int argc, char** argv) {
  rack::scan3d::Scan3d scan;
  return scan.run(argc, argv);
}
