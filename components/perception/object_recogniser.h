// From scans to objects: people, vehicles, and what the map does not have. Pure.
//
// Each scan goes the same way: points that lie where the map has something are explained and left
// out (components/localisation/likelihood_field.h); of the others free_memory.h says which have
// moved, clusters.h which belong together, object_tracker.h which object they are. With a map
// everything that it does not explain is an object, also what stands; without one an object is what
// has moved, and stays one for half a minute when it stops.
//
// All of it happens in the frame of the map or of the odometry. Objects are told in the robot's
// frame, with the robot's position as refPos (as the original's Scan2dDynObjRecog reads them);
// speeds are those over ground, zero as long as an object does not move: its noise is no speed.
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
  double size_max = 12000;   // mm: what is larger is no object
  std::size_t objects_max = 100;
};

class ObjectRecogniser {
 public:
  // The map, if there is one, must outlive this.
  ObjectRecogniser(const RecogniserSettings& settings, const localisation::LikelihoodField* map);

  // `robot`: at the scan's time. False: it was left out: no position, or not newer than the last.
  // When time or robot jump, all objects are forgotten.
  bool take(const Scan2dData& scan, const PositionData& robot);
  // The objects of the last scan that are confirmed, moving ones first, then the nearest. Allocates
  // nothing when `data` has its room.
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
  Pose told_{};   // the last position
  Pose robot_{};  // the same, laid on the map or on earlier scans
  TimeStamp time_ = 0;
  double seconds_ = 0;  // since the first scan
  bool started_ = false;
};

}  // namespace rack::perception
