#include "router/io/net/resolver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <net/if.h>

#include "os/clock.h"
#include "router/io/loop.h"
#include "tests/support/patience.h"

namespace tims::io {
namespace resolver_test {

using link::NetAddress;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

class ResolverTest : public testing::Test {
 protected:
  void resolve(const std::string& host, std::uint16_t port = 2010) {
    resolver_.resolve(host, port, [this](const Result<Resolver::Addresses>& result) {
      results_.push_back(result);
    });
  }

  // Until more results are there; then there are this many.
  void run_until(std::size_t results) {
    const Time limit = os::now() + test::kPatience;
    const std::size_t before = results_.size();
    while (results_.size() == before && os::now() < limit) loop_.run_once(limit);
    ASSERT_EQ(results_.size(), results);
  }

  Loop loop_{};
  std::vector<Result<Resolver::Addresses>> results_{};
  Resolver resolver_{loop_};
};

TEST_F(ResolverTest, NumbersAreAnsweredAtOnce) {
  resolve("10.9.1.1");
  resolve("2001:db8::1");
  ASSERT_EQ(results_.size(), 2);
  EXPECT_THAT(*results_[0], ElementsAre(NetAddress::v4(10, 9, 1, 1, 2010)));
  EXPECT_EQ(results_[1]->at(0).to_string(), "[2001:db8::1]:2010");
}

TEST_F(ResolverTest, LinkLocalAddressesKnowTheirInterface) {
  resolve("fe80::1%lo");
  ASSERT_EQ(results_.size(), 1);
  EXPECT_EQ(results_[0]->at(0).scope, ::if_nametoindex("lo"));
}

TEST_F(ResolverTest, WhatCannotBeANameIsRefusedAtOnce) {
  resolve("fe80::1%gone0");
  resolve("10.9.1.1:2010");
  resolve("");
  ASSERT_EQ(results_.size(), 3);
  EXPECT_THAT(results_[0].error().detail(), HasSubstr("fe80::1%gone0"));
  EXPECT_THAT(results_[1].error().detail(), HasSubstr("10.9.1.1:2010"));
  EXPECT_EQ(results_[2].error().code(), Errc::kInvalidArgument);
}

TEST_F(ResolverTest, NamesAreAnsweredFromTheLoop) {
  resolve("localhost");
  EXPECT_TRUE(results_.empty());
  run_until(1);
  ASSERT_TRUE(results_[0]) << results_[0].error().message();
  EXPECT_THAT(*results_[0], Contains(NetAddress::v4(127, 0, 0, 1, 2010)));
}

TEST_F(ResolverTest, UnknownNamesAreNamed) {
  resolve("robot.invalid");
  run_until(1);
  ASSERT_FALSE(results_[0]);
  EXPECT_THAT(results_[0].error().detail(), HasSubstr("robot.invalid"));
}

TEST_F(ResolverTest, EqualQuestionsGetTheSameAnswer) {
  for (int i = 0; i < 3; ++i) resolve("localhost");
  run_until(3);  // in one turn
  EXPECT_EQ(*results_[0], *results_[2]);
  resolve("localhost", 2011);
  run_until(4);
  EXPECT_EQ(results_[3]->at(0).port, 2011);
}

TEST_F(ResolverTest, ACallbackMayAskAgain) {
  resolver_.resolve("localhost", 2010, [this](const auto& result) {
    results_.push_back(result);
    resolve("localhost");
  });
  run_until(1);
  run_until(2);
  EXPECT_TRUE(results_[1]);
}

TEST_F(ResolverTest, MayEndWithOpenQuestions) {
  for (const char* host : {"localhost", "robot.invalid", "localhost.localdomain"}) resolve(host);
}

}  // namespace resolver_test
}  // namespace tims::io
