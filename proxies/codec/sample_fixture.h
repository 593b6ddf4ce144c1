// A message with a field of every type, for the tests of text output and input.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rack/codec/fields.h"
#include "rack/codec/message_text.h"
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
  tims::Address sender = {};
  Text<8> name = {};
  std::array<f64, 2> pair = {};
  std::array<i8, 2> levels = {};
  u8 imageSize = 0;
  Count pointNum = {};
  Sequence<Pose, 3> points = {};
  Tail<std::byte, 4> image = {};

  [[nodiscard]] std::array<std::int64_t, 1> tail_sizes() const { return {std::int64_t{imageSize}}; }
};

inline std::vector<std::byte> body_of(const Sample& sample) {
  std::vector<std::byte> body(encoded_size(sample));
  EXPECT_TRUE(encode(sample, body));
  return body;
}
inline std::string to_json(const Sample& sample, const PrintStyle& style = {}) {
  return *body_json(kSchema<Sample>, body_of(sample), std::endian::native, style);
}
inline std::string to_text(const Sample& sample, const PrintStyle& style = {}) {
  return *body_text(kSchema<Sample>, body_of(sample), std::endian::native, style);
}

}  // namespace rack::test
