// Pipelines of GStreamer, if its plugins are installed (gstreamer1.0-plugins-base, tools/dev
// setup).
#include <gmock/gmock.h>

#include "tests/support/video_fixture.h"

namespace rack::device {
namespace video_pipelines_test {

using testing::HasSubstr;

class VideoPipelinesTest : public VideoTestBase {
 protected:
  void SetUp() override {
    for (const char* folder :
         {"/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib"})
      if (std::filesystem::exists(std::string(folder) + "/gstreamer-1.0/libgstvideotestsrc.so"))
        return;
    GTEST_SKIP() << "gstreamer1.0-plugins-base is not installed";
  }
};

constexpr const char* kSource =
    "gstreamer:videotestsrc pattern=white ! video/x-raw,width=64,height=48,framerate=50/1";

TEST_F(VideoPipelinesTest, ItsPicturesArrive) {
  for (const char* end : {"", " ! videoconvert ! appsink"}) {
    const auto pipeline = open(std::string(kSource) + end);
    ASSERT_TRUE(receive(*pipeline, 5));
    for (const Frame& frame : frames_) {
      EXPECT_EQ(frame.head, (VideoHead{video::kBgr24, 64, 48, 192}));
      EXPECT_GE(brightness_of(frame), 250);
    }
    EXPECT_GT(frames_[4].when, frames_[0].when);
  }
}

TEST_F(VideoPipelinesTest, ItsEndIsAnErrorWithAReason) {
  EXPECT_THAT(failure_of("gstreamer:videotestsrc num-buffers=3 ! video/x-raw,width=64,height=48"),
              HasSubstr("the stream has ended"));
  EXPECT_GE(frames_.size(), 1U) << "a slow reader gets the newest one";
  EXPECT_THAT(failure_of("gstreamer:nonsense ! appsink"), HasSubstr("no element \"nonsense\""));
  EXPECT_THAT(failure_of("gstreamer:filesrc location=/none ! appsink"),
              HasSubstr("No such file \"/none\""));
}

TEST_F(VideoPipelinesTest, OneThatBlocksForEverIsClosedAtOnce) {
  // No buffer reaches the sink, so that the pipeline never starts.
  auto pipeline = open("gstreamer:fakesrc num-buffers=-1 ! valve drop=true ! appsink");
  const auto received = receive_until(
      *pipeline, [&, end = tims::os::now() + 500ms] { return tims::os::now() > end; });
  ASSERT_TRUE(received) << received.error().message();
  const Time close = tims::os::now();
  pipeline.reset();
  EXPECT_LT(tims::os::now() - close, tims::test::kSlowdown * 1s);
}

}  // namespace video_pipelines_test
}  // namespace rack::device
