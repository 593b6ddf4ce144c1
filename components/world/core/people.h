// People who walk about: each wants to be at some place, goes there by the ways of the roadmap,
// keeps to the right where there is room, stays for a while and wants to be elsewhere. Five times a
// second it looks ahead: another person, a robot or an obstacle in the way makes it
// step aside, wait, and at last turn round; from a robot that comes too near it steps back, also
// while it stays somewhere. It overlooks some robots, and walks against them.
// Nobody ever goes where there is no room for it.
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

inline constexpr double kPersonRadius = 250;  // mm, for whoever meets it

// What of a person can be seen.
struct Figure {
  MapPoint at{};
  double vx = 0;
  double vy = 0;
  double rho = 0;
  double gait = 0;  // rad, of the swing of its legs; it grows with the way
};

// In a plane below the hips.
std::array<Circle, 2> legs(const Figure& person);
double meets(const Ray& ray, const Figure& person, double height);

class People {
 public:
  struct Surroundings {
    const Scenery& scenery;
    std::span<const Box> robots;
    std::span<const Solid> obstacles;  // that were put
  };

  People() = default;
  // No two at one place, none but those of walks near a robot.
  People(const PeopleDescription& description, const Area& area, const Surroundings& around,
         std::uint64_t seed);

  // Who of the description is not there, and why.
  [[nodiscard]] const std::optional<std::string>& problem() const { return problem_; }
  [[nodiscard]] std::size_t size() const { return figures_.size(); }
  [[nodiscard]] std::span<const Figure> figures() const { return figures_; }

  // Who walks against a robot is counted with it.
  void step(const Surroundings& around, std::span<Contacts> contacts);
  void stand();
  // Whether those who touch it overlooked it and walked against it just now.
  [[nodiscard]] bool walked_against(const Box& robot) const;

 private:
  enum class Meeting : std::uint8_t { kNone, kAvoids, kOverlooks };
  struct Mind {
    Mind(std::uint64_t seed, std::uint64_t seed_of_luck) : random(seed), luck(seed_of_luck) {}
    Random random;
    Random luck;  // of meetings: the same, whenever they are
    double speed = 0;
    std::size_t from = 0;  // places
    std::size_t to = 0;
    std::size_t goal = 0;
    int pause = 0;  // steps
    int patience = 0;
    double side = 1;  // of the room beside the way: 1 right, -1 left
    Meeting meeting = Meeting::kNone;
    bool waits = false;
    bool is_stopped = false;  // by somebody, since it looked last
    bool touches = false;
    bool goes_to_line = false;
    bool squeezes = false;                  // past a robot that does not let it through
    std::optional<std::uint64_t> bumped{};  // against a robot, in that step
    // Of a walk: places in turn, the one that comes next, and steps at each.
    std::vector<std::size_t> walk{};
    std::size_t next = 0;
    int rest = 0;
  };
  // The way it is on.
  struct Line {
    MapPoint from{};
    double x = 1;  // direction
    double y = 0;
    double length = 0;
    double room = 0;
    double along = 0;  // where the person is
    double aside = 0;  // to the right

    [[nodiscard]] MapPoint at(double way, double beside) const {
      return {from.x + way * x - beside * y, from.y + way * y + beside * x};
    }
  };

  void add_walker(const WalkDescription& walk, std::uint64_t seed);
  void add_stroller(std::size_t place, std::uint64_t seed);
  [[nodiscard]] Mind mind_at(std::size_t place, std::uint64_t seed) const;
  [[nodiscard]] bool has_room(std::size_t place) const;
  [[nodiscard]] Line line_of(std::size_t person) const;
  [[nodiscard]] int steps_between(Mind& mind, double from_s, double to_s) const;
  [[nodiscard]] int pause_at_goal(Mind& mind) const;
  void choose_goal(Mind& mind) const;
  void turn_round(Mind& mind);
  void look_ahead(std::size_t person, const Surroundings& around);
  bool steps_back(std::size_t person, const Surroundings& around, std::span<Contacts> contacts);
  [[nodiscard]] bool is_free(std::size_t person, double side, bool robots,
                             const Surroundings& around) const;
  bool arrive(std::size_t person);
  void walk(std::size_t person, const Surroundings& around, std::span<Contacts> contacts);
  [[nodiscard]] MapPoint wish(std::size_t person) const;
  [[nodiscard]] bool may_go(std::size_t person, const MapPoint& to, const Surroundings& around,
                            std::span<Contacts> contacts);
  [[nodiscard]] bool meets_somebody(std::size_t person, const MapPoint& to,
                                    const Surroundings& around, std::span<Contacts> contacts);
  void stop(std::size_t person);
  void turn_body(Figure& figure);

  PeopleDescription description_;
  Roadmap roadmap_;
  std::vector<Figure> figures_;
  std::vector<Mind> minds_;
  std::uint64_t steps_ = 0;
  std::optional<std::string> problem_;
};

}  // namespace rack::world
