// Says so when messages came faster than a command could show them.
#pragma once

#include <fmt/format.h>

#include "tools/timsctl/connection.h"
#include "tools/timsctl/output.h"

namespace timsctl {

class Missed {
 public:
  // `what`: "messages".
  explicit Missed(std::string_view what) : what_(what) {}

  void note(const Connection& connection, const Output& out) {
    const std::uint64_t all = connection.missed();
    if (all == told_) return;
    out.note(fmt::format("{} {} were lost: too fast for this output, or larger than --body-max",
                         all - told_, what_));
    told_ = all;
  }

 private:
  std::string_view what_;
  std::uint64_t told_ = 0;
};

}  // namespace timsctl
