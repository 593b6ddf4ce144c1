// A run of Dora: her fleet is brought up, she drives her round, and meanwhile is measured, killed
// in parts and left without eyes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli/connection.h"
#include "tools/dora/ears.h"
#include "tools/dora/judgement.h"
#include "tools/dora/notes.h"
#include "tools/dora/reference_timer.h"
#include "tools/sim/running_fleet.h"

namespace rack::dora {

struct Settings {
  Duration length = std::chrono::seconds(60);
  std::string fleet_file;
  bool quiet = false;  // without a line for each step
};

struct Outcome {
  std::vector<Row> rows;
  TimerQuality timer;
};

class Scenario {
 public:
  Scenario(const Settings& settings, const timsctl::Signals& signals);
  ~Scenario();

  // Throws timsctl::Failure when there can be no fleet, Interrupted at Ctrl-C.
  Outcome run();

 private:
  void bring_up();
  void begin_to_drive();
  void measure_periods(Duration length);
  void kill_routers();
  void kill_router(std::string_view host);
  void judge_periods(const TimerQuality& timer);

  // --- what it does

  void turn_on(std::string_view component);
  [[nodiscard]] tims::Mailbox& work() { return ears_.front()->work(); }
  // How long it takes until she drives, counted from that time (now).
  std::optional<Duration> drives_within(Duration limit, std::optional<Time> since_when = {});
  // Until it is so, or the limit; ears are kept meanwhile.
  bool await(Duration limit, const std::function<bool()>& so);
  void pause(Duration length);
  void say(const std::string& text) const;
  [[nodiscard]] Duration elapsed() const;

  const Settings settings_;
  const timsctl::Signals& signals_;
  const Time began_;
  const std::string name_;
  std::string log_;
  std::optional<timsctl::sim::RunningFleet> fleet_;
  Notes notes_;
  std::vector<std::unique_ptr<Ears>> ears_;  // in the order of kHosts
  std::vector<Row> rows_;
  std::vector<double> stops_ms_;
  std::vector<double> returns_ms_;
};

}  // namespace rack::dora
