// The film of a simulated camera: renders pictures and compresses them to JPEG in a thread of its
// own, with less priority than the world, whose devices must answer in time. A picture that is
// ordered while another one is in work is skipped.
//
// In librack-world-camera, which World loads for a world with a camera: OpenCV's decoders and
// encoders bring 120 libraries (components/pictures/README.md).
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "components/world/core/view.h"
#include "tims/result.h"

namespace rack::world {

class CameraFilm {
 public:
  virtual ~CameraFilm() = default;
  // Whether a picture may be ordered now.
  [[nodiscard]] virtual bool is_free() = 0;
  // Copies the view; no effect if it is not free.
  virtual void expose(const View& view) = 0;
  // The newest picture, once: replaces `jpeg` and returns true.
  virtual bool take(std::vector<std::byte>& jpeg) = 0;
};

// Of a sensor of the kind camera.
using MadeFilm = tims::Result<std::unique_ptr<CameraFilm>>;
MadeFilm make_film(const WorldDescription& world, const SensorId& sensor);

// The name of this function in the library. Calls make_film().
inline constexpr const char* kMakeFilmSymbol = "rack_make_film";
using MakeFilm = void (*)(const WorldDescription& world, const SensorId& sensor, MadeFilm& film);

}  // namespace rack::world
