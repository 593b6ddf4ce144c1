// A message with one of everything, for the tests of what is printed and read.
#pragma once

#include <array>
#include <cstdint>

#include "rack/codec/fields.h"
#include "rack/codec/quantity.h"
#include "tims/address.h"

namespace rack::test {

struct Pose {
  Millimetres<i32> x = 0;
  Radians<f32> rho = 0;
};

struct Sample {
  TimeStamp recordingTime = 0;
  Pose pos = {};
  tims::Address who = {};
  Text<8> name = {};
  std::array<f64, 2> pair = {};
  std::array<i8, 2> levels = {};
  Count pointNum = {};
  Sequence<Pose, 3> points = {};
  Tail<std::byte, 4> image = {};

  [[nodiscard]] std::array<std::int64_t, 1> tail_sizes() const {
    return {static_cast<std::int64_t>(image.size())};
  }
};

}  // namespace rack::test
