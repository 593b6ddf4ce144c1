// From scans to objects: people, vehicles, and everything that is not in the map. Pure.
//
// Each scan passes the same steps. Points on obstacles of the map are explained and left out
// (components/localisation/likelihood_field.h). Of the others, free_memory.h finds those that have
// moved, clusters.h groups them, and object_tracker.h assigns the clusters to objects. With a map,
// everything that it does not explain is an object, also static ones; without a map, an object is
// something that has moved, and it remains one for half a minute after it stops.
//
// All steps use the frame of the map or of the odometry. Objects are published in the robot's
// frame, with the robot's position as refPos (as the original's Scan2dDynObjRecog reads them).
// Speeds are those over ground, and zero while an object does not move, so that noise is not
// reported as speed.
#pragma once

#include <optional>

#include "components/localisation/likelihood_field.h"
#include "components/perception/clusters.h"
#include "components/perception/free_memory.h"
#include "components/perception/object_tracker.h"
#include "rack/proxies/obj_recog.h"
#include "rack/proxies/position.h"
#include "rack/proxies/scan2d.h"

namespace rack::perception {

struct RecogniserSettings {
  Pose scanner{};            // on the robot
  double range_max = 30000;  // mm
  double tolerance = 250;    // mm around what the map has
  double size_max = 12000;   // mm: anything larger is not an object
  std::size_t objects_max = 100;
};

class ObjectRecogniser {
 public:
  // The map, if there is one, must outlive this.
  ObjectRecogniser(const RecogniserSettings& settings, const localisation::LikelihoodField* map);

  // `robot`: at the scan's time. False: the scan was ignored: it has no position, or is not newer
  // than the last one. When time or robot jump, all objects are forgotten.
  bool take(const Scan2dData& scan, const PositionData& robot);
  // The confirmed objects at the last scan: moving ones first, then the nearest. Allocates nothing
  // when `data` has capacity.
  void to_message(ObjRecogData& data);

  bool stop(std::int32_t id) { return tracker_.stop(id); }
  void forget();

  [[nodiscard]] std::span<const Track> tracks() const { return tracker_.tracks(); }

 private:
  [[nodiscard]] Pose lay_on_map(const Pose& robot);
  [[nodiscard]] bool jumped(double seconds, const Pose& robot) const;
  void explain();
  [[nodiscard]] ObjRecogObject describe(const Track& track) const;

  RecogniserSettings settings_;
  const localisation::LikelihoodField* map_;
  ScanView view_;
  FreeMemory memory_;
  ClusterFinder finder_;
  ObjectTracker tracker_;
  std::vector<const Track*> order_;
  PositionData position_{};
  localisation::Beams beams_;
  Pose reported_{};  // the last position, as received
  Pose robot_{};     // the same, aligned with the map or with earlier scans
  TimeStamp time_ = 0;
  double seconds_ = 0;  // since the first scan
  bool started_ = false;
};

}  // namespace rack::perception
