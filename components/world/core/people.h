// Simulated pedestrians. Each has a destination, walks to it along the roadmap, keeps to the right
// where there is room, pauses, and chooses another destination. Five times a second it checks the
// path ahead: for another person, a robot or an obstacle it steps aside, waits, turns around, and
// finally walks to any free place near it; from a robot that comes too near it steps back, also
// during a pause. It overlooks some robots and walks into them. A person never moves to a place
// without room.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "components/geometry/random.h"
#include "components/world/core/roadmap.h"
#include "components/world/core/world.h"

namespace rack::world {

// mm, the room that people keep and need to pass.
inline constexpr double kPersonRadius = 250;
// mm, what a robot touches: a body is 450 mm wide and 250 mm deep, a disc between both.
inline constexpr double kBodyRadius = 200;

// The visible state of a person.
struct Figure {
  MapPoint at{};
  double vx = 0;
  double vy = 0;
  double rho = 0;
  double gait = 0;  // rad, phase of the legs; grows with the distance
};

// The legs in a plane below the hips.
std::array<Circle, 2> legs(const Figure& person);
double meets(const Ray& ray, const Figure& person, double height);

class People {
 public:
  struct Surroundings {
    const Scenery& scenery;
    std::span<const Box> robots;
    std::span<const Solid> obstacles;  // placed by commands
  };

  People() = default;
  // No two people start at the same place, and only those with walks near a robot.
  People(const PeopleDescription& description, const Area& area, const Surroundings& around,
         std::uint64_t seed);

  // The reason why people of the description are missing, if there is one.
  [[nodiscard]] const std::optional<std::string>& problem() const { return problem_; }
  [[nodiscard]] std::size_t size() const { return figures_.size(); }
  [[nodiscard]] std::span<const Figure> figures() const { return figures_; }

  // Counts people who walk into a robot in the contacts of that robot.
  void step(const Surroundings& around, std::span<Contacts> contacts);
  void stand();
  // Whether the people who touch the robot have overlooked it and walked into it just now.
  [[nodiscard]] bool walked_against(const Box& robot) const;

 private:
  enum class Meeting : std::uint8_t { kNone, kAvoids, kOverlooks };
  struct Behaviour {
    Behaviour(std::uint64_t seed, std::uint64_t seed_of_luck) : random(seed), luck(seed_of_luck) {}
    Random random;
    Random luck;  // for meetings: the sequence does not depend on their times
    double speed = 0;
    std::size_t from = 0;  // places of the roadmap
    std::size_t to = 0;
    std::size_t goal = 0;
    int pause = 0;  // steps
    int patience = 0;
    double side = 1;  // side of the path: 1 right, -1 left
    Meeting meeting = Meeting::kNone;
    bool waits = false;
    bool is_stopped = false;  // by a person or robot, since the last check
    bool touches = false;
    bool has_turned = false;  // on its line, since the last place
    bool goes_to_line = false;
    bool squeezes = false;                  // passes close to a robot that blocks it
    std::optional<std::uint64_t> bumped{};  // step in which it walked into a robot
    // For a walk: its places, the index of the next one, and the pause at each in steps.
    std::vector<std::size_t> walk{};
    std::size_t next = 0;
    int rest = 0;
  };
  // The current line of the roadmap.
  struct Line {
    MapPoint from{};
    double x = 1;  // direction
    double y = 0;
    double length = 0;
    double room = 0;
    double along = 0;  // position of the person on it
    double aside = 0;  // to the right

    [[nodiscard]] MapPoint at(double distance, double beside) const {
      return {from.x + distance * x - beside * y, from.y + distance * y + beside * x};
    }
  };

  void add_walker(const WalkDescription& walk, std::uint64_t seed);
  void add_stroller(std::size_t place, std::uint64_t seed);
  [[nodiscard]] Behaviour behaviour_at(std::size_t place, std::uint64_t seed) const;
  [[nodiscard]] bool has_room(std::size_t place) const;
  [[nodiscard]] Line line_of(std::size_t person) const;
  [[nodiscard]] int steps_between(Behaviour& behaviour, double from_s, double to_s) const;
  [[nodiscard]] int pause_at_goal(Behaviour& behaviour) const;
  void choose_goal(Behaviour& behaviour) const;
  void turn_round(Behaviour& behaviour);
  bool leave_line(std::size_t person, const Surroundings& around);
  [[nodiscard]] bool can_walk(const MapPoint& from, const MapPoint& to,
                              const Surroundings& around) const;
  void look_ahead(std::size_t person, const Surroundings& around);
  bool steps_back(std::size_t person, const Surroundings& around, std::span<Contacts> contacts);
  [[nodiscard]] bool is_free(std::size_t person, double side, bool robots,
                             const Surroundings& around) const;
  bool arrive(std::size_t person);
  void walk(std::size_t person, const Surroundings& around, std::span<Contacts> contacts);
  [[nodiscard]] MapPoint target_velocity(std::size_t person) const;
  [[nodiscard]] bool may_go(std::size_t person, const MapPoint& to, const Surroundings& around,
                            std::span<Contacts> contacts);
  [[nodiscard]] bool meets_somebody(std::size_t person, const MapPoint& to,
                                    const Surroundings& around, std::span<Contacts> contacts);
  void stop(std::size_t person);
  void turn_body(Figure& figure);

  PeopleDescription description_;
  Roadmap roadmap_;
  std::vector<Figure> figures_;
  std::vector<Behaviour> behaviours_;
  std::uint64_t steps_ = 0;
  std::optional<std::string> problem_;
};

}  // namespace rack::world
