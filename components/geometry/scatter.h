// How points lie about their mean: along which straight line, how far along it and beside it. Pure.
#pragma once

namespace rack {

// Of one point at least. Seen from a point among them: what is squared then stays small.
class Scatter {
 public:
  struct Mean {
    double x = 0;
    double y = 0;
  };
  // Means of the squared distances from the mean, in the points' unit squared.
  struct Variances {
    double along = 0;   // the straight line through them
    double beside = 0;  // that line
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
  // rad, of the straight line through them: -pi/2 to pi/2.
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
