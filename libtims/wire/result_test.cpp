#include "tims/result.h"

#include <memory>
#include <set>

#include <gtest/gtest.h>

namespace tims {
namespace result_test {

TEST(Errc, EveryCodeHasItsOwnNameAndSentence) {
  std::set<std::string_view> names;
  std::set<std::string_view> sentences;
  const int count = static_cast<int>(Errc::kDiskFull) + 1;
  for (int i = 0; i < count; ++i) {
    const Errc code{static_cast<std::uint8_t>(i)};
    EXPECT_NE(name(code), "unknown");
    EXPECT_EQ(name(code).find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string_view::npos)
        << "names are for scripts: " << name(code);
    names.insert(name(code));
    sentences.insert(sentence(code));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(count));
  EXPECT_EQ(sentences.size(), static_cast<std::size_t>(count));
}

TEST(Errc, NumbersOutsideTheListAreUnknown) {
  EXPECT_EQ(name(Errc{200}), "unknown");
  EXPECT_FALSE(sentence(Errc{200}).empty());
}

TEST(Error, MessageJoinsSentenceAndDetail) {
  EXPECT_EQ(Error(Errc::kAddressInUse, "Ladar(0/0) belongs to pid 4711 (laser)").message(),
            "address in use: Ladar(0/0) belongs to pid 4711 (laser)");
  EXPECT_EQ(Error(Errc::kTimeout).message(), "the time given has passed");
}

Result<int> half(int n) {
  if (n % 2 != 0) return Error(Errc::kInvalidArgument, "odd");
  return n / 2;
}

TEST(Result, HoldsValueOrError) {
  EXPECT_TRUE(half(4));
  EXPECT_EQ(*half(4), 2);
  EXPECT_FALSE(half(3));
  EXPECT_TRUE(half(3).error() == Errc::kInvalidArgument);
  EXPECT_EQ(half(3).error().detail(), "odd");
}

TEST(Result, MovesWhatCannotBeCopied) {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(7);
  const std::unique_ptr<int> taken = *std::move(result);
  EXPECT_EQ(*taken, 7);
}

TEST(Result, OfVoid) {
  const Result<void> good;
  const Result<void> bad = Errc::kFull;
  EXPECT_TRUE(good);
  EXPECT_FALSE(bad);
  EXPECT_TRUE(bad.error() == Errc::kFull);
}

}  // namespace result_test
}  // namespace tims
