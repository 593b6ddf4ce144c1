#include "components/world/render/pedestrian.h"

#include <array>
#include <cmath>

namespace rack::world {

namespace {

constexpr double kAdult = 1700;  // mm: the height of the measures below

// A person's frame: ahead, right, up from the ground; as tall as an adult.
class Body {
 public:
  Body(const Figure& person, double height)
      : at_(person.at),
        c_(std::cos(person.rho)),
        s_(std::sin(person.rho)),
        scale_(height / kAdult) {}

  [[nodiscard]] Point3 point(double ahead, double right, double up) const {
    const double x = ahead * scale_;
    const double y = right * scale_;
    return {at_.x + x * c_ - y * s_, at_.y + x * s_ + y * c_, -up * scale_};
  }
  // Of a place on the ground, in mm of the world.
  [[nodiscard]] double ahead_of(const MapPoint& at) const {
    return ((at.x - at_.x) * c_ + (at.y - at_.y) * s_) / scale_;
  }
  [[nodiscard]] double right_of(const MapPoint& at) const {
    return ((at.y - at_.y) * c_ - (at.x - at_.x) * s_) / scale_;
  }
  [[nodiscard]] Point3 forward() const { return {c_, s_, 0}; }
  [[nodiscard]] Ring ring(double at, double forward, double side) const {
    return {at, forward * scale_, side * scale_};
  }
  [[nodiscard]] double scaled(double mm) const { return mm * scale_; }

 private:
  MapPoint at_;
  double c_;
  double s_;
  double scale_;
};

void draw_leg(Artist& artist, const Body& body, const Circle& foot, double side,
              const Texture& trousers, const Texture& shoe) {
  constexpr double kHip = 900;
  constexpr double kKnee = 480;
  constexpr double kAnkle = 70;
  const double ahead = body.ahead_of(foot.at);
  const double right = body.right_of(foot.at);
  // A leg that is behind lifts its heel.
  const double lift = ahead < 0 ? -ahead * 0.25 : 0;
  const Point3 hip = body.point(0, side * 88, kHip);
  const Point3 knee = body.point(ahead * 0.45 + 25 + lift * 0.6, (side * 88 + right) / 2, kKnee);
  const Point3 ankle = body.point(ahead, right, kAnkle + lift);
  artist.tube(knee, hip, body.forward(),
              std::array{body.ring(-0.08, 0, 0), body.ring(-0.04, 50, 50), body.ring(0, 62, 61),
                         body.ring(0.5, 76, 74), body.ring(1, 92, 88)},
              trousers);
  artist.tube(ankle, knee, body.forward(),
              std::array{body.ring(-0.03, 50, 48), body.ring(0.6, 60, 56), body.ring(1, 61, 60),
                         body.ring(1.06, 50, 50), body.ring(1.1, 0, 0)},
              trousers);
  const Point3 toe = body.point(ahead + 150, right, 32 + lift * 0.3);
  const Point3 heel = body.point(ahead - 60, right, 36 + lift);
  artist.tube(heel, toe, {0, 0, 1},
              std::array{body.ring(0, 0, 0), body.ring(0.05, 34, 36), body.ring(0.7, 34, 46),
                         body.ring(1, 12, 30), body.ring(1, 0, 0)},
              shoe);
}

void draw_arm(Artist& artist, const Body& body, double swing, double side, const Texture& shirt,
              const Texture& skin) {
  const Point3 shoulder = body.point(0, side * 205, 1385);
  const Point3 elbow = body.point(swing * 0.45 - 20, side * 240, 1110);
  const Point3 wrist = body.point(swing + 40, side * 235, 885);
  const Point3 finger = body.point(swing + 75, side * 225, 770);
  artist.tube(elbow, shoulder, body.forward(),
              std::array{body.ring(-0.12, 0, 0), body.ring(-0.08, 30, 28), body.ring(0, 43, 41),
                         body.ring(0.6, 50, 46), body.ring(1, 56, 52), body.ring(1.12, 30, 30),
                         body.ring(1.15, 0, 0)},
              shirt);
  artist.tube(wrist, elbow, body.forward(),
              std::array{body.ring(0, 30, 28), body.ring(1, 42, 40), body.ring(1.1, 30, 28),
                         body.ring(1.14, 0, 0)},
              shirt);
  artist.tube(finger, wrist, body.forward(),
              std::array{body.ring(0, 0, 0), body.ring(0.05, 24, 12), body.ring(0.5, 42, 20),
                         body.ring(1, 26, 22), body.ring(1.2, 24, 20)},
              skin);
}

void draw_head(Artist& artist, const Body& body, const Texture& skin, const Texture& hair) {
  artist.tube(body.point(0, 0, 1430), body.point(12, 0, 1520), body.forward(),
              std::array{body.ring(0, 62, 62), body.ring(1, 56, 54)}, skin);
  artist.ellipsoid(body.point(22, 0, 1578), body.forward(), body.ring(0, 94, 74), body.scaled(226),
                   skin);
  artist.ellipsoid(body.point(0, 0, 1610), body.forward(), body.ring(0, 98, 84), body.scaled(180),
                   hair);
}

std::vector<Texture> of(std::initializer_list<Colour> colours) {
  std::vector<Texture> textures;
  for (const Colour& colour : colours) textures.emplace_back(colour);
  return textures;
}

}  // namespace

Pedestrians::Pedestrians()
    : skins_(of({{224, 178, 150}, {198, 144, 112}, {140, 96, 70}})),
      hairs_(of({{52, 38, 30}, {112, 78, 46}, {30, 28, 28}, {170, 140, 90}})),
      shirts_(of({{44, 62, 112}, {150, 38, 42}, {40, 96, 64}, {232, 228, 216}, {62, 62, 68}})),
      trousers_(of({{38, 42, 56}, {92, 80, 64}, {30, 30, 32}, {70, 84, 112}})),
      shoe_(Colour{34, 28, 26}) {}

void Pedestrians::draw(Artist& artist, std::size_t id, const Figure& person, double height) const {
  const Body body(person, height);
  const Texture& shirt = shirts_[id % shirts_.size()];
  const Texture& skin = skins_[id % skins_.size()];
  const Texture& trousers = trousers_[id % trousers_.size()];
  const auto feet = legs(person);
  constexpr double kLeft = -1;
  constexpr double kRight = 1;
  draw_head(artist, body, skin, hairs_[id % hairs_.size()]);
  artist.tube(body.point(0, 0, 800), body.point(0, 0, 960), body.forward(),
              std::array{body.ring(0, 0, 0), body.ring(0.1, 86, 140), body.ring(0.7, 106, 172),
                         body.ring(1, 98, 164)},
              trousers);
  artist.tube(body.point(0, 0, 830), body.point(0, 0, 1480), body.forward(),
              std::array{body.ring(0.15, 100, 166), body.ring(0.16, 116, 182),
                         body.ring(0.36, 92, 148), body.ring(0.66, 116, 186),
                         body.ring(0.86, 92, 206), body.ring(0.94, 74, 150), body.ring(1, 56, 64)},
              shirt);
  // Each arm swings against the leg of its side.
  const double swing = (body.ahead_of(feet[1].at) - body.ahead_of(feet[0].at)) / 2;
  draw_arm(artist, body, swing * 0.8, kLeft, shirt, skin);
  draw_arm(artist, body, -swing * 0.8, kRight, shirt, skin);
  draw_leg(artist, body, feet[0], kLeft, trousers, shoe_);
  draw_leg(artist, body, feet[1], kRight, trousers, shoe_);
}

}  // namespace rack::world
