#include "router/link/who.h"

#include <array>

#include <gtest/gtest.h>

namespace tims::link {
namespace {

const Identity kRobot{.epoch = 5,
                      .role = Role::kSubsystem,
                      .system = 3,
                      .id = 2,
                      .name = std::string_view("arm"),
                      .message_max = 1 << 20,
                      .classes = {{1, 2, 3, 50, 60, 70, 255}}};

std::span<std::byte> written(const Identity& who, std::span<std::byte> to) {
  ByteWriter out(to);
  put(out, who);
  return out.written();
}

TEST(Who, IsReadAsItWasWritten) {
  std::array<std::byte, kWhoBytesMax> bytes{};
  ByteReader in(written(kRobot, bytes));
  Identity who;
  EXPECT_TRUE(get(in, who));
  EXPECT_EQ(who, kRobot);
  EXPECT_TRUE(in.empty());
}

TEST(Who, TheLongestNameHasRoom) {
  Identity who = kRobot;
  who.name = std::string_view("a name of sixty-three letters, which is the longest there may be!");
  std::array<std::byte, kWhoBytesMax> bytes{};
  EXPECT_EQ(written(who, bytes).size(), kWhoBytesMax);
}

TEST(Who, BytesThatAreNobody) {
  std::array<std::byte, kWhoBytesMax> bytes{};
  const auto all = written(kRobot, bytes);
  Identity who;
  for (std::size_t size = 0; size < all.size(); ++size) {
    ByteReader in(all.first(size));
    EXPECT_FALSE(get(in, who)) << "cut to " << size;
  }
  const auto refused = [&](std::size_t at, std::uint8_t value) {
    auto damaged = bytes;
    damaged[at] = std::byte{value};
    ByteReader in(damaged);
    return !get(in, who);
  };
  EXPECT_TRUE(refused(0, 0)) << "epoch 0";
  EXPECT_TRUE(refused(8, 3)) << "no such role";
  EXPECT_TRUE(refused(12, 200)) << "widths of more than 32 bits";
  EXPECT_TRUE(refused(21, 1)) << "thresholds that do not ascend";
}

}  // namespace
}  // namespace tims::link
