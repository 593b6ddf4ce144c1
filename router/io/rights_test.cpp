#include "router/io/rights.h"

#include <gtest/gtest.h>

#include "security/crypto/tls_fixture.h"
#include "tims/message.h"

namespace tims::io {
namespace rights_test {

Right needed(std::int8_t kind, std::string_view body = {}) {
  return needed_for({.type = kind, .body = body}, AddressWidths{});
}

TEST(Rights, TheHigherOnesIncludeTheLowerOnes) {
  EXPECT_TRUE(has(rights_up_to(Right::kConfigure), Right::kLook));
  EXPECT_TRUE(has(rights_up_to(Right::kDrive), Right::kDrive));
  EXPECT_FALSE(has(rights_up_to(Right::kDrive), Right::kConfigure));
  EXPECT_FALSE(has(rights_up_to(Right::kLook), Right::kDrive));
  EXPECT_FALSE(has({}, Right::kLook));
  for (const Right right : {Right::kLook, Right::kDrive, Right::kConfigure}) {
    EXPECT_EQ(right_of(name(right)), right);
    EXPECT_EQ(highest(rights_up_to(right)), right);
  }
  EXPECT_FALSE(right_of("none"));
  EXPECT_FALSE(right_of("Look"));
}

TEST(Rights, WhoLooksAsksOnly) {
  for (const std::int8_t kind : {type::kGetStatus, type::kGetData, type::kGetContData,
                                 type::kStopContData, type::kGetParam, type::kGetDescription})
    EXPECT_EQ(needed(kind), Right::kLook) << int{kind};
  for (const std::int8_t kind : {type::kOn, type::kOff, type::kData, type::kContData, type::kOk,
                                 std::int8_t{32}, std::int8_t{127}, std::int8_t{-128}})
    EXPECT_EQ(needed(kind), Right::kDrive) << int{kind};
  EXPECT_EQ(needed(type::kSetParam), Right::kConfigure);
  EXPECT_EQ(needed_for({.type = 32, .to_router = true}, {}), Right::kLook) << "its own mailboxes";
}

TEST(Rights, WhoLooksReadsLogsAndMapsOfTheirClassesOnly) {
  const auto needed_by = [](std::uint32_t receiver, std::int8_t kind) {
    return needed_for({.type = kind, .class_id = receiver}, AddressWidths{});
  };
  EXPECT_EQ(needed_by(class_id::kGdos, 20), Right::kDrive);
  EXPECT_EQ(needed_by(class_id::kGdos, 21), Right::kLook) << "GET_LOG";
  EXPECT_EQ(needed_by(class_id::kGdos, 22), Right::kLook) << "GET_TEXTS";
  EXPECT_EQ(needed_by(class_id::kGdos, 23), Right::kDrive);
  EXPECT_EQ(needed_by(class_id::kChassis, 21), Right::kDrive) << "MOVE";
  EXPECT_EQ(needed_by(class_id::kChassis, 22), Right::kLook) << "GET_PARAMETER";
  EXPECT_EQ(needed_by(class_id::kCamera, 22), Right::kDrive) << "SET_FORMAT";
}

TEST(Rights, QuestionsNeedWhatTheyDo) {
  EXPECT_EQ(needed(type::kAdminRequest, R"({"ask":"status"})"), Right::kLook);
  EXPECT_EQ(needed(type::kAdminRequest, "nonsense"), Right::kLook) << "the answer explains";
  EXPECT_EQ(needed(type::kAdminRequest, R"({"ask":"lease","robot":1,"do":"renew"})"),
            Right::kDrive);
  EXPECT_EQ(needed(type::kAdminRequest, R"({"ask":"link","link":"a","do":"down"})"),
            Right::kConfigure);
  const auto agent = [](std::string_view body) {
    return needed_for({.type = type::kAdminRequest, .to_agent = true, .body = body}, {});
  };
  EXPECT_EQ(agent(R"({"ask":"conf_get"})"), Right::kLook);
  EXPECT_EQ(agent(R"({"ask":"conf_apply"})"), Right::kConfigure);
  EXPECT_EQ(agent("nonsense"), Right::kConfigure);
}

// Another router may be of a newer version, and understand what this one does not.
TEST(Rights, WhatIsNotUnderstoodMayChangeAnotherRouter) {
  const SentMessage unknown{
      .type = type::kAdminRequest, .to_router = true, .to_other = true, .body = R"({"ask":"new"})"};
  EXPECT_EQ(needed_for(unknown, {}), Right::kConfigure);
  EXPECT_EQ(asked_of(unknown, {}), policy::Right::kChange);
  SentMessage known = unknown;
  known.body = R"({"ask":"status"})";
  EXPECT_EQ(asked_of(known, {}), policy::Right::kLook);
}

TEST(Rights, AnAddressOfAnotherWidthDoesNotHideAChange) {
  const AddressWidths widths{.system = 12, .class_id = 8, .instance = 6, .local = 6};
  const std::string_view change = R"x({"ask":"route_add","match":"Ladar(4000/0)","via":"a"})x";
  EXPECT_EQ(needed_for({.type = type::kAdminRequest, .body = change}, widths), Right::kConfigure);
}

TEST(Rights, CertificatesMakePersons) {
  using security::MemberRole;
  const auto certificate = security::test_root("any").certificate;
  security::Identity own;
  own.role = MemberRole::kSystem;
  own.system = 3;
  const auto right = [&](MemberRole role, std::uint16_t system, security::Rights rights) {
    security::Identity identity;
    identity.role = role;
    identity.system = system;
    identity.rights = rights;
    return highest(person_of(identity, certificate, own).rights);
  };
  EXPECT_EQ(right(MemberRole::kTop, 0, {}), Right::kConfigure);
  EXPECT_EQ(right(MemberRole::kSubsystem, 3, {}), Right::kDrive);
  EXPECT_EQ(right(MemberRole::kSystem, 4, {}), Right::kLook);
  EXPECT_EQ(right(MemberRole::kUser, 3, rights_up_to(Right::kDrive)), Right::kDrive);
  EXPECT_EQ(right(MemberRole::kUser, 3, {}), Right::kNone);
}

TEST(Rights, CertificatesOfRoutersAreNamedInRules) {
  const auto certificate = security::test_root("any").certificate;
  security::Identity robot;
  robot.role = security::MemberRole::kSystem;
  robot.system = 4;
  robot.name = "robot4";
  EXPECT_EQ(person_of(robot, certificate, {}).proven.identities,
            (std::vector<std::string>{"router:robot4", "system:4", "role:system"}));
  security::Identity user;
  user.role = security::MemberRole::kUser;
  user.name = "anna";
  EXPECT_TRUE(person_of(user, certificate, {}).proven.identities.empty()) << "user:anna";
}

TEST(Rights, ThePolicyIsAskedForWhatAQuestionDoes) {
  using To = policy::Right;
  const auto asked = [](std::string_view body, bool to_agent = false) {
    return asked_of({.type = type::kAdminRequest, .to_agent = to_agent, .body = body}, {});
  };
  EXPECT_EQ(asked(R"({"ask":"status"})"), To::kLook);
  EXPECT_EQ(asked("nonsense"), To::kLook);
  EXPECT_EQ(asked(R"({"ask":"route_del","match":"*"})"), To::kChange);
  EXPECT_EQ(asked(R"({"ask":"lease","robot":1,"do":"renew"})"), To::kDrive);
  EXPECT_EQ(asked(R"({"ask":"login"})"), To::kLogin);
  EXPECT_EQ(asked(R"({"ask":"conf_get"})", true), To::kLook);
  EXPECT_EQ(asked("nonsense", true), To::kChange);
  EXPECT_EQ(asked(R"({"ask":"conf_peer"})", true), To::kAgree);
  EXPECT_EQ(asked(R"({"ask":"conf_peer","ask":"conf_apply"})", true), To::kChange);
  EXPECT_EQ(asked(R"({"ask":"conf_peer"})"), To::kLook) << "to a router, which does not know it";
}

}  // namespace rights_test
}  // namespace tims::io
