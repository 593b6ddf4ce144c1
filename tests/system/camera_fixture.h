// Programs of cameras at the test's own router, their pictures, and recordings for them to play.
#pragma once

#include <span>
#include <string>

#include "components/devices/core/video_frame.h"
#include "rack/devices/capture.h"
#include "rack/proxies/camera.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {

class CameraTest : public ModulesTest {
 protected:
  static constexpr std::uint32_t kCamera = 0x00150000;
  static constexpr std::uint32_t kSecondCamera = 0x00150100;

  // A recording that is composed record by record.
  struct Recording {
    std::string text = rack::device::capture_header("v4l:/dev/video0", "2026-11-23T09:30:00Z");
    Duration time{};

    Recording& add(std::uint32_t id, std::span<const std::byte> bytes, Duration after = 50ms);
    Recording& head(const rack::device::VideoHead& head, Duration after = {});
  };

  void SetUp() override;

  // The option --device with the recording.
  std::string play(const Recording& recording, const std::string& options);
  rack::CameraProxy camera(std::uint32_t address = kCamera);
  rack::CameraData next_picture();
  bool has_status(rack::Status wanted);

  TemporaryFolder folder_;
};

}  // namespace tims::test
