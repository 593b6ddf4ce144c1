// The mean of the last samples: the computation of this component, separate from threads and
// messages, so that it can be tested without a router.
#pragma once

#include <numeric>
#include <span>
#include <vector>

namespace thermometer {

class Smoothing {
 public:
  explicit Smoothing(std::size_t samples) : max_(samples) {}

  void add(int sample) {
    if (samples_.size() == max_) samples_.erase(samples_.begin());
    samples_.push_back(sample);
  }
  [[nodiscard]] int mean() const {
    if (samples_.empty()) return 0;
    return static_cast<int>(std::accumulate(samples_.begin(), samples_.end(), 0LL) /
                            static_cast<long long>(samples_.size()));
  }
  [[nodiscard]] std::span<const int> samples() const { return samples_; }

 private:
  std::size_t max_;
  std::vector<int> samples_;
};

}  // namespace thermometer
