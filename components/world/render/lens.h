// The lens of a camera: turns the picture of a pinhole into that of the lens, by OpenCV's model of
// radial distortion (plumb bob). The pinhole's picture is larger where the lens sees more.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "components/world/core/description.h"

namespace rack::world {

class Lens {
 public:
  explicit Lens(const CameraDescription& camera);

  // Of the pinhole's picture; its focal length is that of the camera.
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] double cx() const { return cx_; }
  [[nodiscard]] double cy() const { return cy_; }

  // `bgr`: width x height x 3 bytes of the camera.
  void apply(std::span<std::uint32_t> pinhole, std::span<std::uint8_t> bgr);

 private:
  CameraDescription camera_;
  int width_;
  int height_;
  double cx_;
  double cy_;
  bool is_straight_;
  // Of each pixel of the camera, its place in the pinhole's picture, in OpenCV's fixed-point form.
  std::vector<std::int16_t> places_;
  std::vector<std::uint16_t> parts_;
  std::vector<std::uint32_t> bent_;
};

}  // namespace rack::world
