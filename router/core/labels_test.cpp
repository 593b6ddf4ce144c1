#include "router/core/labels.h"

#include <gtest/gtest.h>

#include "router/core/event.h"
#include "router/core/ids.h"
#include "router/core/outcome.h"

namespace tims::core {
namespace {

enum class Colour { kRed, kGreen };

TEST(Labels, AListIsCompleteWhenItHasEveryValueInOrder) {
  using L = Label<Colour>;
  const L red{Colour::kRed, "red", ""};
  const L green{Colour::kGreen, "green", ""};
  EXPECT_TRUE(complete(std::array{red, green}, Colour::kGreen));
  EXPECT_FALSE(complete(std::array{green, red}, Colour::kGreen));
  EXPECT_FALSE(complete(std::array{red}, Colour::kGreen));
  EXPECT_FALSE(complete(std::array{red, L{Colour::kGreen, "", ""}}, Colour::kGreen));
}

TEST(Labels, NamesSayWhatTheyMean) {
  EXPECT_EQ(name(Outcome::kQueueReplaced), "queue_replaced");
  EXPECT_EQ(name(PortKind::kWebSocket), "websocket");
  EXPECT_EQ(name(EventKind::kDeleteRefused), "delete_refused");
  EXPECT_EQ(name(CloseReason::kTooLong), "too_long");
  EXPECT_TRUE(sentence(Outcome::kNoRoute).starts_with("nobody"));
}

TEST(Labels, OnlySomeOutcomesMeanThatAMessageWasTaken) {
  EXPECT_TRUE(taken(Outcome::kDelivered));
  EXPECT_TRUE(taken(Outcome::kMailboxReplaced));
  EXPECT_FALSE(taken(Outcome::kQueueReplaced));
}

}  // namespace
}  // namespace tims::core
