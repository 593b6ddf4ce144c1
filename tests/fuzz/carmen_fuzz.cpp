// Any text is refused with a line number, or yields scans with finite beams and an odometry that
// can be queried at any time; likewise a text with the ground truth of this log.
#include <cmath>
#include <vector>

#include "components/localisation/carmen_log.h"
#include "tests/fuzz/fuzz_input.h"
#include "tools/evaluation/mcl_eval/truth.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using tims::fuzz::require;
  namespace localisation = rack::localisation;
  const std::string_view text = tims::fuzz::Input(data, size).text();
  // The ground truth follows after a separator line that cannot be part of a log.
  const auto cut = text.find("\n--\n");
  const auto log = localisation::read_carmen(text.substr(0, cut));
  if (!log) {
    require(!log.error().detail().empty());
    return 0;
  }
  require(!log->scans.empty());
  std::vector<localisation::BeamEnd> beams;
  for (const localisation::LogScan& scan : log->scans) {
    log->beams(scan, beams);
    require(beams.size() <= scan.count);
    for (const auto& beam : beams) require(std::isfinite(beam.x) && std::isfinite(beam.y));
    for (const double lag : {0.0, 0.1, -1e9, 1e9})
      require(std::isfinite(log->odometry_of(scan, lag).x));
  }
  const double lag = localisation::estimate_lag(*log);
  require(lag >= 0 && lag <= 0.31);
  if (cut == std::string_view::npos) return 0;
  const auto truth = rack::mcl_eval::read_truth(text.substr(cut + 4), *log);
  if (!truth) {
    require(!truth.error().detail().empty());
    return 0;
  }
  for (const auto& pose : truth->poses) require(pose.scan < log->scans.size());
  for (const auto& relation : truth->relations)
    require(relation.from < log->scans.size() && relation.to < log->scans.size());
  return 0;
}
