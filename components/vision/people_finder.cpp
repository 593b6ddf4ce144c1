#include "components/vision/people_finder.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::vision {

namespace {

constexpr int kWindowWidth = 64;
constexpr int kWindowHeight = 128;
constexpr double kPersonInWindow = 96;  // pixels
constexpr double kEnlargedMost = 2;     // beyond it, pictures show nothing more
constexpr double kNextSize = 1.1;
constexpr int kSidesOfPicture = 16;  // pixels beyond its left and right edge that are searched
// Part of the smaller of two persons that is inside the other: more, and they are the same.
constexpr double kSamePerson = 0.6;

struct Core {
  double left;
  double right;
  double top;
  double bottom;
};

// The part of a window that a person fills, so that neighbours are told apart.
Core core_of(const PersonBox& box) {
  return {box.left + box.width / 4, box.left + box.width * 3 / 4, box.head(), box.feet()};
}

double area(const Core& core) {
  return std::max(0.0, core.right - core.left) * std::max(0.0, core.bottom - core.top);
}

bool is_same_person(const PersonBox& a, const PersonBox& b) {
  const Core one = core_of(a);
  const Core other = core_of(b);
  const Core both{std::max(one.left, other.left), std::min(one.right, other.right),
                  std::max(one.top, other.top), std::min(one.bottom, other.bottom)};
  return area(both) > kSamePerson * std::min(area(one), area(other));
}

// Windows of nearly the same size, of which the mean is meaningful.
bool is_same_size(const PersonBox& a, const PersonBox& b) {
  constexpr double kMost = 1.4;
  return a.height < kMost * b.height && b.height < kMost * a.height;
}

}  // namespace

double probability_of(double score) { return 1 / (1 + std::exp(-2 * score)); }

std::vector<PersonBox> merged(std::vector<PersonBox> boxes) {
  std::ranges::sort(boxes, std::ranges::greater{}, &PersonBox::score);
  std::vector<PersonBox> people;
  std::vector<bool> is_taken(boxes.size(), false);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (is_taken[i]) continue;
    const PersonBox& best = boxes[i];
    PersonBox sum;
    double weights = 0;
    for (std::size_t k = i; k < boxes.size(); ++k) {
      if (is_taken[k] || !is_same_person(best, boxes[k])) continue;
      is_taken[k] = true;
      if (!is_same_size(best, boxes[k])) continue;
      const double weight = k == i ? std::max(best.score, 1e-3) : std::max(boxes[k].score, 0.0);
      weights += weight;
      sum.left += weight * boxes[k].left;
      sum.top += weight * boxes[k].top;
      sum.width += weight * boxes[k].width;
      sum.height += weight * boxes[k].height;
    }
    people.push_back({sum.left / weights, sum.top / weights, sum.width / weights,
                      sum.height / weights, best.score});
  }
  return people;
}

class PeopleFinder::Detector {
 public:
  Detector() { hog_.setSVMDetector(cv::HOGDescriptor::getDefaultPeopleDetector()); }

  std::vector<PersonBox> find(const GreyView& picture, const PeopleSearch& search) {
    const double factor =
        std::min({kEnlargedMost, kPersonInWindow / search.smallest,
                  static_cast<double>(search.side_max) / std::max(picture.width, picture.height)});
    const cv::Size size(std::max(1, static_cast<int>(picture.width * factor)),
                        std::max(1, static_cast<int>(picture.height * factor)));
    const cv::Mat whole(picture.height, picture.width, CV_8U,
                        const_cast<std::uint8_t*>(picture.pixels.data()));
    cv::resize(whole, sized_, size, 0, 0, factor < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
    // The margin of a person who is as tall as the picture.
    const int margin = (size.height + 5) / 6;
    cv::copyMakeBorder(sized_, framed_, margin, margin, 0, 0, cv::BORDER_REPLICATE);
    std::vector<PersonBox> boxes;
    if (framed_.cols < kWindowWidth || framed_.rows < kWindowHeight) return boxes;
    // Windows with a lower score help to find the mean.
    std::vector<cv::Rect> windows;
    std::vector<double> scores;
    hog_.detectMultiScale(framed_, windows, scores, std::min(search.score_min, 0.0), {8, 8},
                          {kSidesOfPicture, 0}, kNextSize, 0);
    const double across = static_cast<double>(picture.width) / size.width;
    const double down = static_cast<double>(picture.height) / size.height;
    for (std::size_t i = 0; i < windows.size(); ++i)
      boxes.push_back({windows[i].x * across, (windows[i].y - margin) * down,
                       windows[i].width * across, windows[i].height * down, scores[i]});
    return boxes;
  }

 private:
  cv::HOGDescriptor hog_;
  cv::Mat sized_;
  cv::Mat framed_;
};

PeopleFinder::PeopleFinder() : detector_(std::make_unique<Detector>()) {}
PeopleFinder::~PeopleFinder() = default;

tims::Result<std::vector<PersonBox>> PeopleFinder::find(const GreyView& picture,
                                                        const PeopleSearch& search) {
  if (!picture.is_whole())
    return tims::Error(tims::Errc::kMalformed, "the picture has fewer pixels than its size");
  std::vector<PersonBox> people;
  const bool is_empty = picture.width == 0 || picture.height == 0;
  if (is_empty || !(search.smallest > 0) || search.side_max <= 0) return people;
  const auto done = pictures::call_opencv("the search for people",
                                          [&] { people = detector_->find(picture, search); });
  if (!done) return done.error();
  if (search.is_possible)
    std::erase_if(people, [&](const PersonBox& box) { return !search.is_possible(box); });
  people = merged(std::move(people));
  std::erase_if(people, [&](const PersonBox& box) { return box.score < search.score_min; });
  if (people.size() > kPeopleMax) people.resize(kPeopleMax);
  return people;
}

}  // namespace rack::vision
