#include "tests/system/camera_fixture.h"

#include <fstream>

namespace tims::test {

CameraTest::Recording& CameraTest::Recording::add(std::uint32_t id,
                                                  std::span<const std::byte> bytes,
                                                  Duration after) {
  append_record(text, time, rack::device::Direction::kReceived, id, bytes);
  time += after;
  return *this;
}

CameraTest::Recording& CameraTest::Recording::head(const rack::device::VideoHead& head,
                                                   Duration after) {
  return add(rack::device::video::kHead, rack::device::bytes_of(head), after);
}

void CameraTest::SetUp() {
  ModulesTest::SetUp();
  work_.reset();
  work_.emplace(open(*session_, kWork, {.body_max = rack::kCameraBytesMax + 64}));
}

std::string CameraTest::play(const Recording& recording, const std::string& options) {
  const std::string path = folder_.path() / "camera.cap";
  std::ofstream(path) << recording.text;
  return "--device=play:" + path + options;
}

rack::CameraProxy CameraTest::camera(std::uint32_t address) {
  return proxy<rack::CameraProxy>(address);
}

rack::CameraData CameraTest::next_picture() {
  const auto picture = camera().get_next_data(kPatience);
  EXPECT_TRUE(picture) << picture.error().message();
  return picture ? *picture : rack::CameraData{};
}

bool CameraTest::has_status(rack::Status wanted) {
  const auto status = camera().status();
  return status && *status == wanted;
}

}  // namespace tims::test
