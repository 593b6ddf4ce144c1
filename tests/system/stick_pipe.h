// A joystick device controlled by a test: a pipe with the events of the kernel.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "os/file.h"

namespace tims::test {

class StickPipe {
 public:
  explicit StickPipe(const std::string& path) {
    EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0);
    pipe_ = os::File(::open(path.c_str(), O_RDWR | O_CLOEXEC));  // does not wait for the reader
  }
  void push(std::int16_t forward) {
    constexpr std::byte kAxis{2};
    constexpr std::byte kForward{1};
    if (std::exchange(forward_, forward) == forward) return;
    const std::int16_t value = static_cast<std::int16_t>(-forward);
    std::array<std::byte, 8> event{};
    std::memcpy(&event[4], &value, sizeof value);
    event[6] = kAxis;
    event[7] = kForward;
    EXPECT_EQ(::write(pipe_.get(), event.data(), event.size()), 8);
  }

 private:
  os::File pipe_;
  std::int16_t forward_ = 0;
};

}  // namespace tims::test
