#include "router/io/subjects.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace tims::io {
namespace subjects_test {

using Identities = std::vector<std::string>;

std::string uid_text() { return "uid:" + std::to_string(::geteuid()); }

TEST(Subjects, AProgramOfAnotherUserIsKnownByUserGroupsAndUnit) {
  const policy::Subject subject = local_subject({.pid = 1,
                                                 .uid = 64'000,
                                                 .gid = 64'001,
                                                 .groups = {64'001, 64'002},
                                                 .unit = "laser.service",
                                                 .label = "rack"});
  EXPECT_EQ(subject.name, "uid:64000");
  EXPECT_EQ(subject.identities, (Identities{"uid:64000", "gid:64001", "gid:64002",
                                            "unit:laser.service", "label:rack", "port:local"}));
}

TEST(Subjects, OwnIsTheRoutersUserRootAndTheRoutersGroup) {
  const auto is_own = [](uid_t uid, gid_t gid, std::vector<gid_t> groups = {}) {
    return local_subject(
               {.uid = uid, .gid = gid, .groups = std::move(groups), .unit = {}, .label = {}})
        .has("own");
  };
  EXPECT_TRUE(is_own(::geteuid(), 64'001));
  EXPECT_TRUE(is_own(0, 64'001));
  EXPECT_TRUE(is_own(64'000, ::getegid()));
  EXPECT_TRUE(is_own(64'000, 64'001, {::getegid()}));
  EXPECT_FALSE(is_own(64'000, 64'001, {64'002}));
}

TEST(Subjects, AVisitorIsKnownByItsAddressAndOnThisHostByItsUser) {
  EXPECT_EQ(visitor_subject(core::PortKind::kTcp, {.peer = "10.9.1.7:40312"}).identities,
            (Identities{"net:10.9.1.7", "port:tcp"}));
  const Visitor here{.peer = "127.0.0.1:40312", .uid = ::geteuid()};
  const policy::Subject subject = visitor_subject(core::PortKind::kWebSocket, here);
  EXPECT_EQ(subject.name, uid_text());
  EXPECT_TRUE(subject.has("own"));
  EXPECT_TRUE(subject.has("port:websocket"));
}

TEST(Subjects, AUserHasItsRightsAndARouterItsName) {
  const Visitor visitor{.peer = "[fe80::1]:2000"};
  const Person anna{.name = "anna", .rights = rights_up_to(Right::kDrive)};
  EXPECT_EQ(person_subject(core::PortKind::kTcp, anna, visitor).identities,
            (Identities{"user:anna", "right:look", "right:drive", "net:fe80::1", "port:tcp"}));
  Person robot{.name = "robot4", .rights = rights_up_to(Right::kLook)};
  robot.proven.add(policy::kind::kRouter, "robot4");
  const policy::Subject subject = person_subject(core::PortKind::kTcp, robot, visitor);
  EXPECT_EQ(subject.name, "router:robot4");
  EXPECT_FALSE(subject.has("user:robot4"));
  EXPECT_FALSE(subject.is_router()) << "it is no link: all rules may match it";
}

}  // namespace subjects_test
}  // namespace tims::io
