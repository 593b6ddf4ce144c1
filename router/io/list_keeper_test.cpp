#include "router/io/list_keeper.h"

#include <filesystem>
#include <future>

#include <gtest/gtest.h>
#include <unistd.h>

#include "security/keys/authority.h"
#include "tests/support/temporary_folder.h"

namespace tims::io::list_keeper_test {

constexpr std::int64_t kNow = 1'800'000'000;

class ListKeeperTest : public testing::Test {
 protected:
  ListKeeperTest() {
    const security::Identity robot{.fleet = "f",
                                   .role = security::MemberRole::kSystem,
                                   .system = 3,
                                   .id = 1,
                                   .name = "robot3",
                                   .rights = {}};
    EXPECT_TRUE(robot_.make().ok());
    const auto request =
        security::CertificateRequest::make(robot_.next_key().value(), robot.uris()).value();
    EXPECT_TRUE(robot_
                    .take_over(authority_.issue(robot, {}, request, kNow).value(),
                               authority_.list()->roots, authority_.list_bytes().value())
                    .ok());
  }
  CheckedList check(std::uint64_t number, const security::Bytes& bytes, bool believes = true) {
    std::promise<CheckedList> result;
    ListKeeper keeper(robot_, [&](CheckedList&& list) { result.set_value(std::move(list)); });
    if (believes) keeper.set_credentials(robot_.load().value());
    keeper.check(5, number, "base", security::Bytes(bytes));
    CheckedList checked = result.get_future().get();
    EXPECT_EQ(checked.transfer, 5U);
    EXPECT_EQ(checked.from, "base");
    return checked;
  }
  security::Bytes revoke_somebody() {
    EXPECT_TRUE(authority_.revoke("robot3", kNow).ok());
    return authority_.list_bytes().value();
  }

  test::TemporaryFolder folder_;
  security::KeyFolder robot_{(folder_.path() / "robot3").string()};
  security::Authority authority_ =
      security::Authority::init(security::KeyFolder((folder_.path() / "base").string()), "f", kNow)
          .value();
};

TEST_F(ListKeeperTest, AGoodListIsStored) {
  const auto bytes = revoke_somebody();
  const CheckedList checked = check(2, bytes);
  EXPECT_EQ(checked.refused + checked.not_stored, "");
  EXPECT_EQ(checked.list->number, 2U);
  EXPECT_EQ(robot_.load()->list_number(), 2U);
  EXPECT_EQ(check(2, bytes).refused, "") << "once more, in a row of two";
}

TEST_F(ListKeeperTest, ForgedOnesAreRefusedWithAReason) {
  auto bytes = revoke_somebody();
  EXPECT_NE(check(3, bytes).refused.find("the number 2, not the promised 3"), std::string::npos);
  EXPECT_NE(check(2, bytes, false).refused, "") << "nobody is believed yet";
  bytes[20] ^= std::byte{1};
  const CheckedList damaged = check(2, bytes);
  EXPECT_NE(damaged.refused, "");
  EXPECT_EQ(damaged.list, nullptr);
  EXPECT_NE(check(2, {}).refused, "");
  EXPECT_EQ(robot_.load()->list_number(), 1U);
}

TEST_F(ListKeeperTest, WithoutADiskItCountsAllTheSame) {
  const auto bytes = revoke_somebody();
  const security::Credentials own = robot_.load().value();
  std::promise<CheckedList> result;
  ListKeeper keeper(robot_, [&](CheckedList&& list) { result.set_value(std::move(list)); });
  keeper.set_credentials(own);
  std::filesystem::remove_all(robot_.path());  // as an unplugged card
  keeper.check(5, 2, "base", security::Bytes(bytes));
  const CheckedList checked = result.get_future().get();
  EXPECT_EQ(checked.refused, "");
  EXPECT_NE(checked.not_stored, "");
  EXPECT_TRUE(checked.list->revokes(own.chain.front()));
}

}  // namespace tims::io::list_keeper_test
