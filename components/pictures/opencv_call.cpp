#include "components/pictures/opencv_call.h"

#include <new>
#include <string>

#include <opencv2/core.hpp>

namespace rack::pictures {

namespace detail {

tims::Result<void> run_opencv(std::string_view task, void (*function)(void*), void* context) {
  try {
    function(context);
    return {};
  } catch (const cv::Exception& error) {
    // Without the place in OpenCV's sources, which what() begins with.
    return tims::Error(tims::Errc::kMalformed, std::string(task) + ": " + error.err);
  } catch (const std::bad_alloc&) {
    return tims::Error(tims::Errc::kTooBig, std::string(task) + ": not enough memory");
  }
}

}  // namespace detail

void use_one_thread() { cv::setNumThreads(1); }

}  // namespace rack::pictures
