// A run of Dora: starts the fleet, lets the robot drive its round, measures it and injects faults
// (killed routers, an unplugged laser, obstacles).
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "components/geometry/random.h"
#include "os/file.h"
#include "tools/cli/connection.h"
#include "tools/evaluation/dora/judgement.h"
#include "tools/evaluation/dora/load.h"
#include "tools/evaluation/dora/notes.h"
#include "tools/evaluation/dora/reference.h"
#include "tools/evaluation/dora/subscriptions.h"
#include "tools/sim/running_fleet.h"

namespace rack::dora {

struct Settings {
  Duration length = std::chrono::seconds(60);
  std::string fleet_file{};
  std::string logs{};  // folder for the logs of all programs; empty: they are not kept
  bool quiet = false;  // do not print a line for each step
};

struct Outcome {
  std::vector<Row> rows;
  Reference reference;
};

// The components that record their input: the pilot and the drivers.
inline constexpr std::string_view kPilot = "Pilot(1/0)";
inline constexpr std::array kRecorded = {
    kPilot, std::string_view("Chassis(1/0)"), std::string_view("Gyro(1/0)"),
    std::string_view("Gps(1/0)"), std::string_view("Ladar(1/0)")};

class Scenario {
 public:
  Scenario(const Settings& settings, const timsctl::Signals& signals);
  ~Scenario();

  // Throws timsctl::Failure if the fleet cannot be started, Interrupted at Ctrl-C.
  Outcome run();

 private:
  void bring_up();
  void begin_to_drive();
  void measure_periods(Duration length);
  void kill_routers();
  // Appends the reaction times for (b) to `reactions`, ms.
  void try_obstacles(Time until, std::vector<double>& reactions);
  void try_obstacles_under_load(Duration length);
  void step_before_her(std::vector<double>& reactions);
  void appear_before_her();
  void stand_and_remove(i32 post, u32 contacts_before);
  void pull_out_her_eyes();
  void carry_her_away();
  void drive_by_satellites(Duration length);
  void note_cross_track_errors(Time since);
  void kill_router(std::string_view host);
  void replay_all();
  void replay_her_pilot();
  void replay_driver(std::string_view component);
  void judge_periods(const Reference& reference);
  void judge_trials(const TimerQuality& timer);
  void judge_reactions(const TimerQuality& timer);
  void judge_means(const TimerQuality& timer);

  // --- steps and helpers

  void record_all();
  [[nodiscard]] std::string recording_of(std::string_view component) const;
  void ask(std::string_view component, const std::function<Result<void>(Proxy&)>& question);
  void turn_on(std::string_view component);
  // Moves the robot to the start of its round and initialises Position there.
  void begin_round();
  // Starts another round if less than `rest` mm of this one are left or the robot does not drive.
  void keep_driving(double rest = 15000);
  [[nodiscard]] bool is_near_end(double rest) const;
  [[nodiscard]] bool is_short() const;
  std::optional<i32> put_post(double ahead);
  void remove_post(i32 id);
  [[nodiscard]] std::string where_she_is() const;
  void save_logs() const;
  [[nodiscard]] std::string drive_csv() const;
  [[nodiscard]] std::string other_contacts() const;
  [[nodiscard]] static tims::Address world();
  [[nodiscard]] static Parameter integer_parameter(std::string_view name, i32 value);
  [[nodiscard]] static TimeStamp wall_of(Time time);
  [[nodiscard]] tims::Mailbox& work() { return subscriptions_.front()->work(); }
  // On the host that simulates the world.
  [[nodiscard]] tims::Mailbox& base() { return subscriptions_.back()->work(); }
  // Waits until the robot drives; returns the time that took since `since_when` (default: now).
  std::optional<Duration> drives_within(Duration limit, std::optional<Time> since_when = {});
  // Waits until `so` holds (true) or the limit has passed (false). Renews the subscriptions.
  bool await(Duration limit, const std::function<bool()>& so);
  void pause(Duration length);
  void print_progress(const std::string& text) const;
  [[nodiscard]] Duration elapsed() const;

  tims::os::File alone_;
  const Settings settings_;
  const timsctl::Signals& signals_;
  const Time began_;
  const std::string name_;
  std::string log_;
  std::optional<timsctl::sim::RunningFleet> fleet_;
  Notes notes_;
  std::vector<std::unique_ptr<Subscriptions>>
      subscriptions_;  // in the order of kHosts, then the base
  std::vector<Row> rows_;
  Random random_{17};
  int posts_ = 0;
  u32 contacts_ = 0;
  Time driving_since_{};
  std::vector<double> reactions_ms_;
  std::vector<double> loaded_reactions_ms_;
  std::optional<Load> load_;
  std::string no_load_;  // why the load could not be started
  Duration obstacles_for_{};
  std::vector<double> unplugged_ms_;
  std::vector<double> plugged_ms_;
  std::vector<double> lateral_mm_;
  std::vector<double> position_mm_;
  std::vector<double> satellite_errors_;
  std::vector<double> stops_ms_;
  std::vector<double> returns_ms_;
};

}  // namespace rack::dora
