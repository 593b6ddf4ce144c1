// The scatter of points about their mean: the best straight line, and the variances along it and
// across it. Pure.
#pragma once

namespace rack {

// Needs at least one point. Use coordinates relative to a point among them, so that squares stay
// small.
class Scatter {
 public:
  struct Mean {
    double x = 0;
    double y = 0;
  };
  // Mean squared distances from the mean, in squared units of the points.
  struct Variances {
    double along = 0;   // along the line
    double beside = 0;  // across the line
  };

  void add(double x, double y) {
    ++points_;
    x_ += x;
    y_ += y;
    xx_ += x * x;
    xy_ += x * y;
    yy_ += y * y;
  }

  [[nodiscard]] int points() const { return points_; }
  [[nodiscard]] Mean mean() const { return {x_ / points_, y_ / points_}; }
  [[nodiscard]] Variances variances() const;
  // Direction of the line, rad: -pi/2 to pi/2.
  [[nodiscard]] double direction() const;

 private:
  struct Moments {
    double xx = 0;
    double xy = 0;
    double yy = 0;
  };
  [[nodiscard]] Moments about_mean() const;

  int points_ = 0;
  double x_ = 0;
  double y_ = 0;
  double xx_ = 0;
  double xy_ = 0;
  double yy_ = 0;
};

}  // namespace rack
