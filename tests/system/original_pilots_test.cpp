// The windows for Path, Pilot and Planner of the original's GUI with our components: a robot is
// sent to destinations and along clicked points, and the painted curves are checked.
#include <cmath>
#include <numbers>

#include "rack/proxies/path.h"
#include "rack/proxies/planner.h"
#include "tests/system/original_window.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace original_pilots_test {

using rack::i32;

constexpr std::uint32_t kPosition = 0x00130000;
constexpr std::uint32_t kPilot = 0x00180000;
constexpr std::uint32_t kPlanner = 0x00220000;
constexpr std::uint32_t kPath = 0x00250000;
using PathType = rack::PathType;
using PilotType = rack::PilotType;

struct Place {
  double x = 0;
  double y = 0;
};
double distance(const Place& a, const Place& b) { return std::hypot(a.x - b.x, a.y - b.y); }

struct Spline {
  std::array<i32, 12> basepoint{};
  std::array<Place, 3> places{};  // start, end, centre
  std::array<double, 3> rho{};
  double length = 0;
  double radius = 0;
  i32 half_width = 0;  // lbo
};

std::vector<Spline> splines_of(Fields& fields) {
  std::vector<Spline> splines(static_cast<std::size_t>(fields.next<i32>()));
  for (Spline& spline : splines) {
    for (i32& value : spline.basepoint) value = fields.next<i32>();
    for (std::size_t i = 0; i < 3; ++i) {
      spline.places[i].x = fields.next<i32>();
      spline.places[i].y = fields.next<i32>();
      spline.rho[i] = static_cast<double>(fields.next<float>());
    }
    spline.length = fields.next<i32>();
    spline.radius = fields.next<i32>();
    fields.skip<i32>(7);
    spline.half_width = fields.next<i32>();
  }
  EXPECT_TRUE(fields.rest().empty());
  return splines;
}

// A point of a circular arc as Java paints it: angles are counterclockwise around the centre.
Place on_circle(const Spline& spline, double angle) {
  const double radius = std::abs(spline.radius);
  return {spline.places[2].x + radius * std::cos(angle),
          spline.places[2].y - radius * std::sin(angle)};
}

// The path window paints from the start over the angle length / radius. A stroke of negative width
// would abort its painting.
void check_stroke(const Spline& spline) {
  EXPECT_GE(spline.half_width, 0);
  if (spline.radius == 0) {
    EXPECT_NEAR(distance(spline.places[0], spline.places[1]), std::abs(spline.length), 3);
    return;
  }
  const double turned = spline.length / spline.radius;
  const double side = (turned >= 0 ? 1 : -1) * (spline.length >= 0 ? 1 : -1);
  const double start = -spline.rho[0] + side * std::numbers::pi / 2;
  EXPECT_LT(distance(on_circle(spline, start), spline.places[0]), 20);
  EXPECT_LT(distance(on_circle(spline, start - turned), spline.places[1]), 20);
}

// The pilot window has a formula for each side and direction, and paints counterclockwise.
void check_arc(const Spline& spline) {
  if (spline.radius == 0) return;
  const double open = std::abs(spline.length / spline.radius);
  const bool is_right = spline.radius > 0;
  const bool is_forward = spline.length >= 0;
  double start =
      (is_right ? std::numbers::pi / 2 - spline.rho[0] : -spline.rho[1] - std::numbers::pi / 2);
  if (is_forward) start -= open;
  const bool ends_first = is_forward == is_right;
  const Place first = on_circle(spline, start);
  const Place last = on_circle(spline, start + open);
  EXPECT_LT(distance(first, spline.places[ends_first ? 1 : 0]), 20);
  EXPECT_LT(distance(last, spline.places[ends_first ? 0 : 1]), 20);
}

class OriginalPilotsTest : public RobotTest {
 protected:
  void SetUp() override {
    RobotTest::SetUp();
    gui_.emplace(router_.tcp());
    start("ChassisSim", {"--omegaMax=90", "--periodTime=50", "--acceleration=1", "--vxMax=1000",
                         "--accMax=1000", "--decMax=1000"});
    start("OdometryChassis");
    start("Position");
  }
  Window open_window(std::uint32_t component) { return gui_->open_window(component); }
  void start_pilot() {
    start("PathRDDF");
    start("PilotPath", {"--scan2dInst=-1"});
    activate_pilot();
  }
  void activate_pilot() {
    ASSERT_TRUE(turned_on("Position(0/0)"));
    ASSERT_TRUE(turned_on("Chassis(0/0)"));
    ASSERT_TRUE(proxy<rack::ChassisProxy>("Chassis(0/0)").set_active_pilot(Address(kPilot)));
    ASSERT_TRUE(turned_on("Pilot(0/0)"));
  }
  testing::AssertionResult comes_to(Window& position, const Place& place) {
    return eventually(
        [&]() -> std::string {
          const auto message = position.poll();
          if (!message) return "no position";
          Fields fields(*message);
          fields.next<i32>();
          const Place at{1.0 * fields.next<i32>(), 1.0 * fields.next<i32>()};
          const double away = distance(at, place);
          return away < 150 ? "" : std::to_string(away) + " mm away";
        },
        3 * kPatience);
  }

  std::optional<OriginalGui> gui_;
};

// --- Path

class PathWindow {
 public:
  explicit PathWindow(const Window& window) : window_(window) {}

  void press_on() {
    ASSERT_TRUE(eventually([&] { return window_.answer_to(type::kOn) == type::kOk; }, "it is on"));
  }
  // The direction is a float; -1 marks fields that MAKE must not change.
  void click_destination(i32 x, i32 y, float rho, float direction) {
    destination_answer_ =
        window_.answer_to(PathType::kSetDestination, Body().add(x, y, rho, direction).add(i32{0}));
    make();
    points_.clear();
  }
  void click_base_point(i32 x, i32 y, i32 direction) {
    points_.push_back({x, y, direction});
    send_points();
  }
  void clear() {
    points_.clear();
    send_points();
  }
  [[nodiscard]] int answer_to_destination() const { return destination_answer_; }

  // Gets a path that was not painted yet, if there is one; paths are identified by their time.
  bool look() {
    const auto message = window_.poll();
    if (!message) return false;
    Fields fields(*message);
    const i32 version = fields.next<i32>();
    if (version == version_) return false;
    version_ = version;
    path_ = splines_of(fields);
    EXPECT_EQ(message->body.size(), 8 + 124 * path_.size());
    for (const Spline& spline : path_) check_stroke(spline);
    return true;
  }
  // The end of the path; far away if there is none.
  [[nodiscard]] Place end() const {
    return path_.empty() ? Place{1e9, 1e9} : path_.back().places[1];
  }
  testing::AssertionResult shows_path_to(const Place& place) {
    return eventually([&] { return look() && distance(end(), place) < 60; }, "the path wanted");
  }
  [[nodiscard]] const std::vector<Spline>& path() const { return path_; }

 private:
  void make() {
    EXPECT_EQ(window_.answer_to(PathType::kMake, Body().add(i32{-1}, i32{-1}, i32{-1}, -1.0F)),
              type::kOk);
  }
  void send_points() {
    Body body;
    body.add(static_cast<i32>(points_.size()));
    for (const auto& [x, y, direction] : points_) body.add(x, y, direction).text("", 36);
    EXPECT_EQ(window_.answer_to(PathType::kSetRddf, body), type::kOk);
    make();
  }

  Window window_;
  std::vector<std::array<i32, 3>> points_;
  std::vector<Spline> path_;
  i32 version_ = -1;
  int destination_answer_ = 0;
};

TEST_F(OriginalPilotsTest, PathsAreCreatedByClicksAndPainted) {
  start("PathRDDF");
  PathWindow window(open_window(kPath));
  window.press_on();
  window.click_destination(6000, 3000, 1.5F, 1);
  EXPECT_EQ(window.answer_to_destination(), type::kOk);
  EXPECT_TRUE(window.shows_path_to({6000, 3000}));
  window.click_destination(-3000, 2000, 0, -1);
  EXPECT_TRUE(window.shows_path_to({-3000, 2000}));
  EXPECT_LT(window.path().front().length, 0) << "backward";
  // Clicks after a destination create a separate path through their points.
  window.click_base_point(2000, 0, 1);
  EXPECT_TRUE(window.shows_path_to({2000, 0}));
  window.click_base_point(4000, 2500, 1);
  EXPECT_TRUE(window.shows_path_to({4000, 2500}));
  EXPECT_EQ(window.path().back().basepoint[0], 4000);
  // An unreachable destination: the old path is kept, and is not a path through old clicks.
  window.click_destination(900'000, 0, 0, 1);
  EXPECT_EQ(window.answer_to_destination(), type::kError);
  EXPECT_FALSE(window.look());
  window.clear();
  EXPECT_TRUE(eventually([&] { return window.look() && window.path().empty(); }, "no path"));
  window.click_destination(6000, 3000, 1.5F, 1);
  EXPECT_TRUE(window.shows_path_to({6000, 3000}));
  window.clear();
  EXPECT_TRUE(eventually([&] { return window.look() && window.path().empty(); }, "no path"));
}

// --- Pilot

struct Shown {
  Place at;
  Place goal;
  i32 speed = 0;
  i32 left = 0;
  i32 state = 0;
  std::vector<Spline> path;
};

std::optional<Shown> look(Window& window) {
  const auto message = window.poll();
  if (!message) return {};
  Fields fields(*message);
  fields.next<i32>();
  Shown shown;
  for (Place* place : {&shown.at, &shown.goal}) {
    place->x = fields.next<i32>();
    place->y = fields.next<i32>();
    fields.skip<i32>(4);
  }
  shown.speed = fields.next<i32>();
  EXPECT_TRUE(std::isfinite(fields.next<float>())) << "the window divides by the curvature";
  shown.left = fields.next<i32>();
  shown.state = fields.next<i32>();
  shown.path = splines_of(fields);
  EXPECT_EQ(message->body.size(), 72 + 124 * shown.path.size());
  for (const Spline& spline : shown.path) check_arc(spline);
  return shown;
}

// A click on the map has speed 1 or -1: forward or backward.
Body destination(i32 x, i32 y, float rho, i32 speed) {
  return Body().add(x, y, i32{0}, 0.0F, 0.0F, rho).add(speed);
}
Body hold(i32 state) { return Body().add(state, i32{0}).text("", 24); }

TEST_F(OriginalPilotsTest, AClickSetsTheDestinationAndHoldStopsIt) {
  Window window = open_window(kPilot);
  start_pilot();
  Window position = open_window(kPosition);
  EXPECT_EQ(look(window)->left, -1);
  EXPECT_EQ(window.answer_to(PilotType::kSetDestination, destination(900'000, 0, 0, 1)),
            type::kError);
  ASSERT_EQ(window.answer_to(PilotType::kSetDestination, destination(4000, 1500, 0.5F, 1)),
            type::kOk);
  const auto shows = [&](const auto& what, const std::string& name) {
    return eventually(
        [&] {
          const auto shown = look(window);
          return shown && what(*shown);
        },
        name);
  };
  EXPECT_TRUE(shows([](const Shown& s) { return s.speed > 300; }, "it drives"));
  EXPECT_TRUE(shows(
      [](const Shown& s) {
        return !s.path.empty() && distance(s.goal, {4000, 1500}) < 60;
      },
      "the path and its end"));
  ASSERT_EQ(window.answer_to(PilotType::kHoldCommand, hold(1)), type::kOk);
  EXPECT_TRUE(shows([](const Shown& s) { return s.speed == 0; }, "it stands"));
  ASSERT_EQ(window.answer_to(PilotType::kHoldCommand, hold(0)), type::kOk);
  EXPECT_TRUE(comes_to(position, {4000, 1500}));
  EXPECT_TRUE(shows([](const Shown& s) { return s.left == 0; }, "it has arrived"));
  ASSERT_EQ(window.answer_to(PilotType::kSetDestination, destination(2500, 700, 0.5F, -1)),
            type::kOk);
  EXPECT_TRUE(shows([](const Shown& s) { return s.speed < -100; }, "it drives backward"));
  EXPECT_TRUE(comes_to(position, {2500, 700}));
}

TEST_F(OriginalPilotsTest, ThePilotOfTheExampleReachesAClickedDestination) {
  start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
  start("PilotLab", {"--scan2dInst=0"});
  activate_pilot();
  Window window = open_window(kPilot);
  Window position = open_window(kPosition);
  ASSERT_EQ(window.answer_to(PilotType::kSetDestination, destination(1500, -500, 0, 1)), type::kOk);
  EXPECT_TRUE(comes_to(position, {1500, -500}));
  EXPECT_EQ(window.answer_to(PilotType::kHoldCommand, hold(1)), type::kError)
      << "it does not support hold";
}

// --- Planner

class PlannerWindow {
 public:
  explicit PlannerWindow(const Window& window) : window_(window) {}

  // The commands of its selection box, which is filled when the window opens.
  std::vector<std::string> names() {
    const auto message = window_.ask(rack::PlannerType::kGetCommand);
    if (!message) return {};
    EXPECT_EQ(message->header.type, rack::PlannerType::kCommand);
    Fields fields(*message);
    return texts(fields);
  }
  void press_on() {
    ASSERT_TRUE(eventually([&] { return window_.answer_to(type::kOn) == type::kOk; }, "it is on"));
  }
  // The typed text follows directly after the name.
  int send(const std::string& name, const std::string& typed) {
    const std::string text = name + typed;
    return window_.answer_to(rack::PlannerType::kCommand,
                             Body().add(i32{1}, static_cast<i32>(text.size())).text(text, 80));
  }
  // A new line of its table: the first message, if it differs from the last.
  testing::AssertionResult shows(const std::string& wanted, i32 state) {
    return eventually(
        [&]() -> std::string {
          const auto message = window_.poll();
          if (!message) return "no data";
          Fields fields(*message);
          fields.next<i32>();
          const i32 reported = fields.next<i32>();
          const auto lines = texts(fields);
          EXPECT_FALSE(lines.empty()) << "without a message the window cannot send";
          if (lines.empty()) return "nothing";
          return reported == state && lines[0].starts_with(wanted) ? "" : lines[0];
        },
        3 * kPatience);
  }

 private:
  // Each text states its length; each has room for 80 bytes.
  static std::vector<std::string> texts(Fields& fields) {
    std::vector<std::string> texts(static_cast<std::size_t>(fields.next<i32>()));
    for (std::string& text : texts) {
      const auto length = static_cast<std::size_t>(fields.next<i32>());
      text = fields.text(80).substr(0, length);
    }
    EXPECT_TRUE(fields.rest().empty());
    return texts;
  }

  Window window_;
};

TEST_F(OriginalPilotsTest, ThePlannerIsCommandedBySelectionAndText) {
  start("PathRDDF");
  start("PilotPath", {"--scan2dInst=-1"});
  start("Planner");
  PlannerWindow window(open_window(kPlanner));
  const auto names = window.names();
  ASSERT_FALSE(names.empty()) << "there is nothing to choose from";
  EXPECT_EQ(names[0], "goto");
  ASSERT_TRUE(turned_on("Position(0/0)"));
  window.press_on();
  EXPECT_TRUE(window.shows("no task", 0));
  EXPECT_EQ(window.send("goto", "somewhere"), type::kError);
  EXPECT_EQ(window.send("goto", "1500 0"), type::kOk);
  EXPECT_TRUE(window.shows("now: goto 1500 0", 1));
  Window position = open_window(kPosition);
  EXPECT_TRUE(comes_to(position, {1500, 0}));
  EXPECT_TRUE(window.shows("all done", 0));
  EXPECT_EQ(window.send("goto", "9000 1200"), type::kOk);
  EXPECT_TRUE(comes_to(position, {2500, 0}));
  EXPECT_EQ(window.send("stop", ""), type::kOk);
  Window pilot = open_window(kPilot);
  EXPECT_TRUE(eventually([&] { return look(pilot)->speed == 0; }, "it stands"));
  EXPECT_EQ(window.send("goto", "900000 0"), type::kOk);
  EXPECT_TRUE(window.shows("goto 900000 0: ", 2));
}

}  // namespace original_pilots_test
}  // namespace tims::test
