// Finds upright people in grey pictures: N. Dalal, B. Triggs, "Histograms of Oriented Gradients for
// Human Detection", 2005, with the detector that OpenCV has for it.
//
// A window of 64 x 128 pixels, with a person of about 96 pixels in it, is moved over the picture in
// several sizes; a linear classifier scores the directions of the edges in it. One person is found
// in many windows: those that overlap are merged to one box.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "components/vision/grey_view.h"
#include "tims/result.h"

namespace rack::vision {

// The window around a person, pixels of the picture; may be partly outside of it.
struct PersonBox {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;
  double score = 0;  // of the classifier: larger is more certain, 0 is undecided

  [[nodiscard]] double middle() const { return left + width / 2; }
  // The window has a margin above and below the person.
  [[nodiscard]] double head() const { return top + kHead * height; }
  [[nodiscard]] double feet() const { return top + kFeet * height; }

  // As in the pictures that the detector has learnt from. The deviations of what it finds are in
  // person_place.cpp.
  static constexpr double kHead = 16.0 / 128;
  static constexpr double kFeet = 112.0 / 128;
};

struct PeopleSearch {
  // Height of the smallest person to be found, pixels of the picture. A picture is searched in the
  // size in which such a person just fills the window, or in the largest size that side_max allows.
  double smallest = 96;
  int side_max = 640;  // pixels, of the longer side of the searched picture: bounds the time
  double score_min = 0.5;
  // Windows that show nobody, for example since they float above the ground, do not count: people
  // are often found a second time in windows around a part of them. Empty: all count.
  std::function<bool(const PersonBox&)> is_possible{};
};

// 0 to 1 of a score. A logistic function as J. Platt's, with a slope for which the margin of the
// classifier (a score of 1) is 0.88.
double probability_of(double score);

// Boxes of one person become one, at their mean by score; the best first. Pure.
std::vector<PersonBox> merged(std::vector<PersonBox> boxes);

// Not thread-safe.
class PeopleFinder {
 public:
  static constexpr std::size_t kPeopleMax = 50;  // in one picture: those with the highest scores

  PeopleFinder();
  ~PeopleFinder();
  PeopleFinder(PeopleFinder&&) = delete;

  // kMalformed: fewer pixels than the size requires, or OpenCV reports an error.
  tims::Result<std::vector<PersonBox>> find(const GreyView& picture, const PeopleSearch& search);

 private:
  class Detector;
  std::unique_ptr<Detector> detector_;
};

}  // namespace rack::vision
