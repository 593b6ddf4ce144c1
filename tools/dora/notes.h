// What was heard in a run: when messages came, and of some what they said. Any thread.
#pragma once

#include <array>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/position.h"
#include "rack/proxies/scan2d.h"
#include "tools/dora/ears.h"

namespace rack::dora {

struct PilotNote {
  Time at;
  i32 speed = 0;  // that it commanded; the chassis had it before
  u32 state = 0;
};
// Of one scan: the points that are something.
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

  // Every position that was heard, with the time it is of.
  [[nodiscard]] std::vector<PositionData> positions() const;

 private:
  void take_scan(const tims::MessageView& message, Time at);

  mutable std::mutex mutex_;
  bool counts_ = false;
  std::array<std::vector<std::vector<Time>>, kStreams.size()> spans_;
  std::array<std::optional<Time>, kStreams.size()> last_;
  std::vector<PilotNote> pilots_;
  std::vector<ScanNote> scans_;
  std::vector<PositionData> positions_;
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
