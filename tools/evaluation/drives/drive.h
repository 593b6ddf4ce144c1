// One goal drive of a simulated robot, from a seed to a result. Pure.
//
// The seed decides everything: the start, the goal, the people, the noise of the sensors, and when
// which program waits. A drive holds when the robot arrives, or stands safely and reports why it
// does not; when no contact is its own; and when Position never was certain of a wrong place.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "components/localisation/floor_plan.h"
#include "components/path/free_space.h"
#include "components/world/core/description.h"
#include "tools/evaluation/drives/machine.h"
#include "tools/plot/picture.h"

namespace rack::drives {

// A world with a robot, and the plan by which the robot drives.
struct Scene {
  std::string name;
  world::WorldDescription world{};
  localisation::FloorPlan plan{};
};

struct DriveSettings {
  std::uint64_t seed = 1;
  Load load{};
  tims::Duration longest = std::chrono::minutes(4);
  bool starts_anywhere = false;  // at a random place, which the localiser has to find
  bool records = false;          // keeps trajectories for the picture
};

enum class Outcome : std::uint8_t { kArrived, kNoPath, kGaveUp };

struct DriveResult {
  Outcome outcome = Outcome::kGaveUp;
  double seconds = 0;
  double off_goal = 0;              // mm, at the end, of the true pose
  std::uint64_t contacts = 0;       // that are the robot's
  double wrong_while_certain = 0;   // mm, worst error of the position while it was certain
  double turned_while_certain = 0;  // rad, the same of the heading
  Pose start{};
  Pose goal{};
  std::string why{};  // what the pilot reported at the end
  std::vector<std::string> log{};
  plot::Picture picture{};

  // Certain: deviation below 0.2 m; wrong: more than 0.5 m or 10 degrees.
  [[nodiscard]] bool was_certain_of_a_wrong_place() const;
  [[nodiscard]] bool holds() const;
};

// Prepared once for all drives in a scene.
class Course {
 public:
  // kInvalidArgument: the world or its plan cannot be used.
  static tims::Result<Course> make(Scene scene);
  Course(Course&&) noexcept;
  ~Course();

  [[nodiscard]] DriveResult drive(const DriveSettings& settings) const;
  // A pose with room around it that a robot of the scene can reach.
  [[nodiscard]] Pose draw_goal(Random& random) const;

 private:
  struct Parts;
  explicit Course(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace rack::drives
