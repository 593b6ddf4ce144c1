#include "shm/layout.h"

#include <cstring>
#include <memory>
#include <new>

#include <gtest/gtest.h>

namespace tims::shm {

namespace layout_test {

class CheckedViewTest : public testing::Test {
 protected:
  CheckedViewTest() {
    std::memset(memory_, 0, sizeof memory_);
    MailboxView::create(memory_, 128,
                        {.address = Address(0x00140000), .slots = 4, .message_max = 80});
  }
  MailboxHeader& header() { return *reinterpret_cast<MailboxHeader*>(memory_ + 128); }
  bool opens(std::uint64_t offset = 128) { return MailboxView::open(memory_, offset).ok(); }

  alignas(128) std::byte memory_[8192];
};

TEST_F(CheckedViewTest, OpensWhatWasCreated) {
  const auto view = MailboxView::open(memory_, 128);
  ASSERT_TRUE(view.ok()) << view.error().message();
  EXPECT_EQ(view->geometry().slots, 4U);
  EXPECT_EQ(view->address(), Address(0x00140000));
}

TEST_F(CheckedViewTest, RefusesWhatDoesNotLieInside) {
  for (const std::uint64_t offset :
       {std::uint64_t{8192}, std::uint64_t{8064}, std::uint64_t{129}, ~std::uint64_t{127}})
    EXPECT_FALSE(opens(offset)) << offset;
}

TEST_F(CheckedViewTest, RefusesEveryTamperedNumber) {
  const auto with = [this](auto tamper) {
    const MailboxHeader& h = header();
    std::byte saved[32];
    std::memcpy(saved, &h, sizeof saved);
    tamper(header());
    const bool open = opens();
    std::memcpy(static_cast<void*>(&header()), saved, sizeof saved);
    return open;
  };
  EXPECT_FALSE(with([](auto& h) { h.ready.store(0, std::memory_order_relaxed); }));
  EXPECT_FALSE(with([](auto& h) { h.version = 3; }));
  EXPECT_FALSE(with([](auto& h) { h.slots = 0; }));
  EXPECT_FALSE(with([](auto& h) { h.slots = 65536; }));
  EXPECT_FALSE(with([](auto& h) { h.slots = 60; }));  // more than fit
  EXPECT_FALSE(with([](auto& h) { h.message_max = 15; }));
  EXPECT_FALSE(with([](auto& h) { h.message_max = ~0U; }));
  EXPECT_FALSE(with([](auto& h) { h.wake = static_cast<WakeKind>(3); }));
  EXPECT_TRUE(opens());
}

TEST(Geometry, PartsDoNotOverlapAndEverySlotIsAligned) {
  for (const std::uint32_t slots : {1U, 2U, 63U, 64U, 1000U, kSlotsMax})
    for (const std::uint32_t message_max : {16U, 48U, 49U, 80U, 4080U}) {
      const Geometry g = Geometry::of(slots, message_max);
      EXPECT_GE(g.ring, 2 * slots);
      EXPECT_EQ(g.free_at - g.arrival_at, g.ring * sizeof(std::uint64_t));
      EXPECT_GE(g.slots_at, g.free_at + g.ring * sizeof(std::uint64_t));
      EXPECT_GE(g.stride, sizeof(SlotHeader) + message_max);
      EXPECT_EQ(g.stride % 64, 0U);
      EXPECT_EQ(g.short_max, message_max - kHeaderSize);
      EXPECT_EQ(g.bytes, g.slots_at + slots * g.stride);
    }
}

TEST(Geometry, LongBodiesLieBehindTheSlots) {
  for (const std::uint32_t slots : {1U, 2U, 1000U})
    for (const std::uint32_t message_max : {4081U, 16U << 20, kMessageMax}) {
      const Geometry g = Geometry::of(slots, message_max);
      EXPECT_EQ(g.long_places, slots);
      EXPECT_FALSE(g.shares_places());
      EXPECT_EQ(g.stride, 2176U);
      EXPECT_EQ(g.short_max, 2176U - sizeof(SlotHeader) - kHeaderSize);
      EXPECT_GE(g.long_at, g.slots_at + slots * g.stride);
      EXPECT_GE(g.long_stride, message_max - kHeaderSize);
      EXPECT_EQ(g.long_at % 128, 0U);
      EXPECT_EQ(g.long_stride % 256, 128U);
      EXPECT_EQ(g.bytes, g.long_at + std::uint64_t{slots} * g.long_stride);  // 1 TB
    }
}

TEST(Geometry, FewerPlacesThanSlotsAreShared) {
  const Geometry g = Geometry::of(512, 1 << 20, 16);
  EXPECT_TRUE(g.shares_places());
  EXPECT_GE(g.slots_at, g.holders_at + 16 * sizeof(std::uint64_t));
  EXPECT_EQ(g.bytes, g.long_at + 16 * g.long_stride);
  EXPECT_EQ(Geometry::of(512, 1 << 20, 513).long_places, 512U);
  EXPECT_EQ(Geometry::of(512, 4080, 16).long_places, 0U);
}

}  // namespace layout_test

}  // namespace tims::shm
