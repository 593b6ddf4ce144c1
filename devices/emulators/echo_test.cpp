#include "devices/emulators/echo.h"

#include <array>

#include <gtest/gtest.h>

namespace rack::device {
namespace {

class Sent final : public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    bytes_.assign(bytes.begin(), bytes.end());
    id_ = id;
  }

  std::vector<std::byte> bytes_;
  std::uint32_t id_ = 0;
};

TEST(EchoTest, SaysWhatItHearsWithItsIdentifier) {
  Echo echo;
  Sent out;
  echo.start(Time{}, out);
  EXPECT_TRUE(out.bytes_.empty());
  const std::array heard = {std::byte{1}, std::byte{0}, std::byte{0xFF}};
  echo.on_arrival({.bytes = heard, .id = 0x181}, out);
  EXPECT_EQ(out.bytes_, std::vector<std::byte>(heard.begin(), heard.end()));
  EXPECT_EQ(out.id_, 0x181U);
  EXPECT_EQ(echo.next_timeout(), tims::kNever);
}

}  // namespace
}  // namespace rack::device
