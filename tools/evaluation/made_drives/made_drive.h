// A drive through a made building, as a CARMEN log with the true pose of each scan. Pure.
//
// The robot follows its route with a small waviness, and turns at corners on the spot. The odometry
// is wrong like that of real robots: a scale, a turn for each metre, noise, and slips, when the
// wheels turn and the robot does not. The scanner has noise. People walk ahead of the robot and
// against it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "components/geometry/pose.h"
#include "tools/evaluation/made_drives/sites.h"

namespace rack::made_drives {

struct DriveKind {
  std::uint64_t seed = 1;
  double length = 1e6;             // m, the drive ends here or at the end of the route
  double scan_distance = 0.2;      // m between two scans
  double scan_turn = radians(10);  // the largest turn between two scans
  double range_max = 80;           // m
  std::size_t beams = 181;
  double range_noise = 0.015;        // m
  double scale = 0.03;               // share of the distance, standard deviation over all drives
  double drift = radians(0.7);       // rad per m, likewise
  double turn_scale = 0.03;          // share of each turn, likewise
  double turn_noise = radians(1.5);  // rad for a metre
  double slip_distance = 30;         // m between two slips
  double slip_turn = radians(6);     // rad
  double slip_length = 0.12;         // m
  std::size_t people = 3;
};

struct MadeScan {
  double time = 0;  // s
  Pose truth{};     // of the robot and its scanner, RACK's axes, mm
  Pose odometry{};
  std::vector<float> ranges{};  // m, from right to left over 180 degrees
};

std::vector<MadeScan> drive(const Site& site, const DriveKind& kind);

// ODOM and FLASER lines.
std::string to_carmen(const std::vector<MadeScan>& scans);
// `time index x y theta`, as mcl-eval and map-maker read them.
std::string to_truth(const std::vector<MadeScan>& scans);

}  // namespace rack::made_drives
