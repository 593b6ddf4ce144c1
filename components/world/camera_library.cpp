#include "components/world/camera_library.h"

#include <utility>

#include "components/files/loaded_library.h"

namespace rack::device {

namespace {

using world::CameraFilm;

tims::Result<world::MakeFilm> load_film() {
  auto make_film = load_function<world::MakeFilm>(kWorldCameraLibrary, world::kMakeFilmSymbol);
  if (make_film) return make_film;
  return tims::Error(tims::Errc::kSystem,
                     "pictures of a simulated camera need " + make_film.error().detail());
}

// The view is copied while the world stands still; the rest is done by the film's thread.
class WorldPictures final : public emulator::PictureSource {
 public:
  WorldPictures(const world::World& world, const world::SensorId& sensor,
                std::unique_ptr<CameraFilm> film)
      : world_(world), sensor_(sensor), film_(std::move(film)) {}

  [[nodiscard]] Duration period() const override { return sensor().period; }
  void order(Time when) override {
    if (!film_->is_free()) return;
    world_.view(sensor_, when - sensor().lag, view_);
    film_->expose(view_);
  }
  bool take(std::vector<std::byte>& jpeg) override { return film_->take(jpeg); }

 private:
  [[nodiscard]] const world::SensorDescription& sensor() const {
    return world_.description().robots[sensor_.robot].sensors[sensor_.sensor];
  }

  const world::World& world_;
  world::SensorId sensor_;
  std::unique_ptr<CameraFilm> film_;
  world::View view_;
};

}  // namespace

tims::Result<std::shared_ptr<emulator::PictureSource>> pictures_of(const world::World& world,
                                                                   const world::SensorId& sensor) {
  static const auto make_film = load_film();
  if (!make_film) return make_film.error();
  world::MadeFilm film = std::unique_ptr<CameraFilm>();
  (*make_film)(world.description(), sensor, film);
  if (!film) return film.error();
  return std::shared_ptr<emulator::PictureSource>(
      std::make_shared<WorldPictures>(world, sensor, std::move(*film)));
}

}  // namespace rack::device
