// Emulator of the compass of heading.h: turns slowly.
#pragma once

#include <span>
#include <string>

#include <rack/devices/dialogue.h>

namespace heading {

class HeadingCompass final : public rack::device::Dialogue {
 public:
  void start(tims::Time, rack::device::Output&) override {}
  void on_arrival(const rack::device::Arrival& arrival, rack::device::Output& out) override {
    for (const std::byte byte : arrival.bytes) {
      if (byte != std::byte{'?'}) continue;
      const std::string answer =
          std::to_string(tenths_ / 10) + "." + std::to_string(tenths_ % 10) + "\n";
      out.send(std::as_bytes(std::span(answer)));
      tenths_ = (tenths_ + 1) % 3600;
    }
  }

 private:
  int tenths_ = 0;
};

}  // namespace heading
