#include "tests/sim/findings.h"

#include <cstdio>

namespace tims::sim {

void Findings::fail(const std::string& what) {
  if (failures_.size() < 20) failures_.push_back(what);
  print("WRONG: " + what);
}

void Findings::print(const std::string& what) const {
  if (!verbose_) return;
  const std::chrono::duration<double> now = network_.now().time_since_epoch();
  std::printf("%10.4f  %s\n", now.count() - 100, what.c_str());
}

}  // namespace tims::sim
