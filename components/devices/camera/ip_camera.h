// An IP camera that sends its pictures by HTTP, as the cameras of many manufacturers do:
//
//   GET /             motion JPEG without end (multipart/x-mixed-replace, each part a JPEG picture)
//   GET /picture.jpg  one picture
//
// The emulated camera, for tests and simulated robots. It takes pictures only while a client wants
// them. Each part is sent as one piece, so that a client that reads too slowly misses pictures, but
// never parts of one.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "components/devices/core/scene.h"

namespace rack::device::emulator {

struct IpCameraSettings {
  std::shared_ptr<PictureSource> pictures{};  // none: two test pictures in turn
};

class IpCamera final : public Dialogue {
 public:
  static constexpr std::size_t kRequestBytesMax = 8192;
  static constexpr std::size_t kPictureBytesMax = 1 << 22;

  explicit IpCamera(IpCameraSettings settings = {});

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

 private:
  enum class Task : std::uint8_t { kNone, kPicture, kStream };

  void answer(std::string_view request, Time now, Output& out);
  void begin(Task task, Time now);
  void refuse(std::string_view status, std::string_view more, Output& out);
  void send_text(std::string_view text, Output& out);
  void send_picture(Output& out);

  std::shared_ptr<PictureSource> pictures_;
  Task task_ = Task::kNone;
  std::string request_;
  bool is_ordered_ = false;  // a picture is being made
  Time due_{};               // of the next picture
  std::vector<std::byte> jpeg_;
  std::vector<std::byte> piece_;
};

}  // namespace rack::device::emulator
