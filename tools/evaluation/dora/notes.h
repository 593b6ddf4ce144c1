// A record of the messages received in a run: arrival times, and the content of some messages.
// Thread-safe.
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
#include "tools/evaluation/dora/subscriptions.h"

namespace rack::dora {

struct PilotNote {
  Time at;
  i32 speed = 0;  // commanded, mm/s; the chassis has already received the command
  u32 state = 0;
};
struct TruthNote {
  Time at;
  TimeStamp recorded = 0;
  Pose pose;
  double speed = 0;      // mm/s, forward
  double travelled = 0;  // distance driven since the start of the world, mm
  // Numbers of collisions.
  u32 posts = 0;  // with posts placed during the run
  u32 walls = 0;  // with walls and parked cars
  u32 people = 0;
};
// A pose reported by Position, and the true state at its time.
struct PositionNote {
  Time at;
  Pose pose;
  TruthNote truth;

  [[nodiscard]] double error() const;  // mm
};
struct ScanNote {
  Time at;
  TimeStamp recorded = 0;
  bool in_region = false;  // a point is in the region set by look_at()
};

class Notes {
 public:
  Notes();
  void take(std::size_t stream, const tims::MessageView& message, Time at);

  // Deliberate interruptions of the data are kept out of the spans.
  void begin_span();
  void end_span();
  [[nodiscard]] bool counts() const;
  [[nodiscard]] std::vector<std::vector<Time>> spans(std::size_t stream) const;

  [[nodiscard]] std::optional<Time> last(std::size_t stream) const;
  // The first note at or after `after` for which `so` holds.
  [[nodiscard]] std::optional<PilotNote> pilot(
      Time after, const std::function<bool(const PilotNote&)>& so) const;
  [[nodiscard]] std::optional<PilotNote> newest_pilot() const;
  [[nodiscard]] PositionData position() const;
  [[nodiscard]] PathData path() const;

  // Sets the region in which scans are searched for points, mm in the vehicle's frame, and forgets
  // earlier scans.
  void look_at(double x, double y, double radius);
  [[nodiscard]] std::optional<ScanNote> seen(TimeStamp after) const;

  // True states and reported positions since a time.
  [[nodiscard]] TruthNote truth() const;
  [[nodiscard]] std::vector<TruthNote> truths(Time since) const;
  [[nodiscard]] std::vector<PositionNote> positions(Time since) const;
  [[nodiscard]] std::vector<double> position_errors(Time since) const;  // mm

 private:
  void take_scan(const tims::MessageView& message, Time at);
  void take_truth(const tims::MessageView& message, Time at);
  [[nodiscard]] std::optional<TruthNote> truth_of(TimeStamp time) const;

  // With priority inheritance: a reader cannot delay the receiving threads.
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

// The index in kStreams of a component.
std::size_t stream_of(std::string_view component);

}  // namespace rack::dora
