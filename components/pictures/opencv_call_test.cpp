#include "components/pictures/opencv_call.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace rack::pictures {
namespace opencv_call_test {

TEST(OpenCvCall, ExceptionsBecomeErrors) {
  int calls = 0;
  EXPECT_TRUE(call_opencv("counting", [&] { ++calls; }));
  EXPECT_EQ(calls, 1);
  const auto failed = call_opencv("adding", [] {
    cv::Mat sum;
    cv::add(cv::Mat(2, 2, CV_8U), cv::Mat(3, 3, CV_8U), sum);
  });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code(), tims::Errc::kMalformed);
  EXPECT_THAT(failed.error().detail(), testing::StartsWith("adding: "));
  const auto large = call_opencv("growing", [] { throw std::bad_alloc(); });
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code(), tims::Errc::kTooBig);
}

TEST(OpenCvCall, WorkIsDoneInTheCallingThread) {
  use_one_thread();
  EXPECT_EQ(cv::getNumThreads(), 1);
}

}  // namespace opencv_call_test
}  // namespace rack::pictures
