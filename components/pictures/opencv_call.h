// The border to OpenCV: how every function of this project calls it. Needs no header of OpenCV.
#pragma once

#include <memory>
#include <string_view>
#include <type_traits>

#include "tims/result.h"

namespace rack::pictures {

namespace detail {
tims::Result<void> run_opencv(std::string_view task, void (*function)(void*), void* context);
}  // namespace detail

// Runs `function`. OpenCV reports errors by exceptions; here they become an error kMalformed:
// "TASK: reason". `task`: what is done, for example "decoding JPEG".
template <typename Function>
tims::Result<void> call_opencv(std::string_view task, Function&& function) {
  using Plain = std::remove_reference_t<Function>;
  return detail::run_opencv(
      task, [](void* context) { (*static_cast<Plain*>(context))(); },
      const_cast<void*>(static_cast<const void*>(std::addressof(function))));
}

// To be called once when a component starts. By default OpenCV divides a picture among threads, one
// per core, that it creates when it is first used. They inherit the priority of the calling thread:
// those of a real-time task would occupy all cores, and the task would wait for them. With one
// thread there are no others: all work is done in the calling thread, with its priority.
void use_one_thread();

}  // namespace rack::pictures
