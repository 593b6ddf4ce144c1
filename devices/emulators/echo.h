// A device that says what it hears: to try a line with, and `timsctl device record`.
#pragma once

#include "devices/core/dialogue.h"

namespace rack::device {

class Echo final : public Dialogue {
 public:
  void start(Time, Output&) override {}
  void on_arrival(const Arrival& arrival, Output& out) override;
};

}  // namespace rack::device
