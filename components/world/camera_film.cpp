#include "components/world/camera_film.h"

#include <condition_variable>
#include <csignal>
#include <mutex>
#include <thread>
#include <utility>

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>

#include "components/pictures/jpeg.h"
#include "components/pictures/opencv_call.h"
#include "components/world/render/camera_renderer.h"

namespace rack::world {

namespace {

class RenderedFilm final : public CameraFilm {
 public:
  explicit RenderedFilm(std::unique_ptr<CameraRenderer> renderer)
      : renderer_(std::move(renderer)), thread_([this] { work(); }) {}
  ~RenderedFilm() override {
    {
      const std::lock_guard lock(mutex_);
      is_ended_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

  bool is_free() override {
    const std::lock_guard lock(mutex_);
    return !is_ordered_;
  }
  void expose(const View& view) override {
    {
      const std::lock_guard lock(mutex_);
      if (is_ordered_) return;
      ordered_ = view;
      is_ordered_ = true;
    }
    changed_.notify_one();
  }
  bool take(std::vector<std::byte>& jpeg) override {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(is_ready_, false)) return false;
    jpeg.swap(ready_);
    return true;
  }

 private:
  // The thread inherits the priority of the world, which its devices need, and must not have it.
  static void become_patient() {
    const sched_param none{};
    ::pthread_setschedparam(::pthread_self(), SCHED_OTHER, &none);
    constexpr int kNice = 5;
    ::setpriority(PRIO_PROCESS, 0, kNice);  // of this thread only
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
  }

  void work() {
    become_patient();
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return is_ordered_ || is_ended_; });
      if (is_ended_) return;
      std::swap(view_, ordered_);
      lock.unlock();
      const bool is_made = make();
      lock.lock();
      is_ordered_ = false;
      if (!is_made) continue;
      ready_.swap(jpeg_);
      is_ready_ = true;
    }
  }

  bool make() {
    const auto picture = renderer_->render(view_);
    if (!picture) return false;
    const CameraDescription& camera = renderer_->camera();
    const pictures::PixelView view{.layout = pictures::PixelLayout::kBgr,
                                   .size = {static_cast<std::uint32_t>(camera.width),
                                            static_cast<std::uint32_t>(camera.height)},
                                   .bytes = *picture};
    return static_cast<bool>(
        compressor_.encode(view, camera.quality, picture->size() + 4096, jpeg_));
  }

  std::unique_ptr<CameraRenderer> renderer_;  // these are used by the thread only
  pictures::Jpeg compressor_;
  View view_;
  std::vector<std::byte> jpeg_;

  std::mutex mutex_;  // protects what follows
  std::condition_variable changed_;
  View ordered_;
  bool is_ordered_ = false;
  bool is_ended_ = false;
  bool is_ready_ = false;
  std::vector<std::byte> ready_;

  std::thread thread_;  // last: it uses all members above
};

}  // namespace

MadeFilm make_film(const WorldDescription& world, const SensorId& sensor) {
  pictures::use_one_thread();
  auto renderer = CameraRenderer::make(world, sensor);
  if (!renderer) return renderer.error();
  return std::unique_ptr<CameraFilm>(std::make_unique<RenderedFilm>(std::move(*renderer)));
}

}  // namespace rack::world

extern "C" __attribute__((visibility("default"))) void rack_make_film(
    const rack::world::WorldDescription& world, const rack::world::SensorId& sensor,
    rack::world::MadeFilm& film) {
  film = rack::world::make_film(world, sensor);
}
