// What was heard in a run: when messages came, and of some what they said. Any thread.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "components/geometry/pose.h"
#include "rack/priority_mutex.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/position.h"
#include "rack/proxies/scan2d.h"
#include "rack/proxies/world.h"
#include "tools/evaluation/dora/ears.h"

namespace rack::dora {

struct PilotNote {
  Time at;
  i32 speed = 0;  // that it commanded; the chassis had it before
  u32 state = 0;
};
struct TruthNote {
  Time at;
  TimeStamp recorded = 0;
  Pose pose;
  double speed = 0;  // mm/s, forward
  double way = 0;    // mm, since the world began
  // It has driven against.
  u32 posts = 0;  // of what was put there
  u32 walls = 0;  // and parked cars
  u32 people = 0;
};
// What Position said, and where she truly was then.
struct PositionNote {
  Time at;
  Pose pose;
  TruthNote truth;

  [[nodiscard]] double error() const;  // mm
};
struct ScanNote {
  Time at;
  TimeStamp recorded = 0;
  bool in_region = false;  // something is where look_at() said
};

class Notes {
 public:
  Notes();
  void take(std::size_t stream, const tims::MessageView& message, Time at);

  // Gaps that somebody made on purpose are between two spans.
  void begin_span();
  void end_span();
  [[nodiscard]] bool counts() const;
  [[nodiscard]] std::vector<std::vector<Time>> spans(std::size_t stream) const;

  [[nodiscard]] std::optional<Time> last(std::size_t stream) const;
  // The first since `after` of which that is so.
  [[nodiscard]] std::optional<PilotNote> pilot(
      Time after, const std::function<bool(const PilotNote&)>& so) const;
  [[nodiscard]] std::optional<PilotNote> newest_pilot() const;
  [[nodiscard]] PositionData position() const;
  [[nodiscard]] PathData path() const;

  // In the vehicle's frame: from here on scans are looked at whether something is there, mm.
  void look_at(double x, double y, double radius);
  [[nodiscard]] std::optional<ScanNote> seen(TimeStamp after) const;

  // What was true and what was believed, since then.
  [[nodiscard]] TruthNote truth() const;
  [[nodiscard]] std::vector<TruthNote> truths(Time since) const;
  [[nodiscard]] std::vector<PositionNote> positions(Time since) const;
  [[nodiscard]] std::vector<double> position_errors(Time since) const;  // mm

 private:
  void take_scan(const tims::MessageView& message, Time at);
  void take_truth(const tims::MessageView& message, Time at);
  [[nodiscard]] std::optional<TruthNote> truth_of(TimeStamp time) const;

  // Whoever reads has the priority of the thread that has heard something: it is not late for that.
  mutable PriorityMutex mutex_;
  bool counts_ = false;
  std::array<std::vector<std::vector<Time>>, kStreams.size()> spans_;
  std::array<std::optional<Time>, kStreams.size()> last_;
  std::vector<PilotNote> pilots_;
  std::vector<ScanNote> scans_;
  struct Believed {
    Time at;
    PositionData data;
  };
  std::vector<Believed> positions_;
  std::vector<TruthNote> truths_;
  WorldData world_;
  PathData path_;
  Scan2dData scan_;
  PilotData pilot_;
  double region_x_ = 0;
  double region_y_ = 0;
  double region_radius_ = 0;
};

// By its component.
std::size_t stream_of(std::string_view component);

}  // namespace rack::dora
