#include "router/policy/subject.h"

#include <gtest/gtest.h>

namespace tims::policy::subject_test {

bool matches(std::string_view pattern, std::string_view subject) {
  return SubjectPattern::parse(pattern)->matches(*Subject::parse(subject));
}
bool covers(std::string_view wide, std::string_view narrow) {
  return SubjectPattern::parse(wide)->covers(*SubjectPattern::parse(narrow));
}

TEST(Subject, IsNamedAfterItsFirstIdentity) {
  Subject subject;
  subject.add(kind::kUid, 1000).add(kind::kGid, 100).add_own();
  EXPECT_EQ(subject.name, "uid:1000");
  EXPECT_TRUE(subject.has("gid:100"));
  EXPECT_TRUE(subject.has("own"));
  EXPECT_FALSE(subject.has("uid:100"));
}

TEST(Subject, IsParsedFromAListOfIdentities) {
  EXPECT_EQ(Subject::parse("uid:1000, gid:100")->identities.size(), 2U);
  EXPECT_TRUE(Subject::parse("router:base")->is_router());
  EXPECT_FALSE(Subject::parse("user:base")->is_router());
  for (const char* wrong : {"", "uid:", "uid:x", "usr:guest", "user:*", "*", "net:1.2.3"})
    EXPECT_FALSE(Subject::parse(wrong)) << wrong;
}

TEST(Subject, PatternsMatchWholeIdentitiesAndBeginnings) {
  EXPECT_TRUE(matches("*", "uid:1"));
  EXPECT_TRUE(matches("uid:1", "gid:7, uid:1"));
  EXPECT_FALSE(matches("uid:1", "uid:10"));
  EXPECT_TRUE(matches("uid:*", "uid:10"));
  EXPECT_TRUE(matches("unit:rack-*", "unit:rack-pilot.service"));
  EXPECT_FALSE(matches("unit:rack-*", "unit:rack"));
  EXPECT_TRUE(matches("own", "own"));
  EXPECT_FALSE(matches("own", "uid:0"));
}

TEST(Subject, RoutersAreMetOnlyByRulesThatNameThem) {
  EXPECT_FALSE(matches("*", "router:base"));
  EXPECT_TRUE(matches("router:*", "router:base"));
  EXPECT_TRUE(matches("system:3", "router:r3, system:3"));
  EXPECT_FALSE(matches("system:3", "router:r3, system:4"));
  EXPECT_FALSE(covers("*", "router:base"));
  EXPECT_TRUE(matches("other-robot", "router:r3, other-robot"));
  EXPECT_FALSE(matches("other-robot", "router:r3"));
  EXPECT_FALSE(matches("*", "other-robot"));
  EXPECT_TRUE(Subject::parse("other-robot")->is_router());
}

TEST(Subject, NetworksAreComparedByTheirBits) {
  EXPECT_TRUE(matches("net:10.9.0.0/16", "net:10.9.1.7"));
  EXPECT_FALSE(matches("net:10.9.0.0/16", "net:10.8.255.255"));
  EXPECT_TRUE(matches("net:0.0.0.0/0", "net:1.2.3.4"));
  EXPECT_FALSE(matches("net:0.0.0.0/0", "net:fe80::1"));
  EXPECT_TRUE(matches("net:fe80::/10", "net:fe80::1%eth0"));
  EXPECT_TRUE(matches("net:10.9.1.7", "net:::ffff:10.9.1.7"));
  EXPECT_TRUE(matches("net:::/0", "net:::1"));
  EXPECT_TRUE(matches("net:*", "net:::1"));
  for (const char* wrong : {"net:10.9.0.0/33", "net:300.1.1.1", "net:1:2", "net:::1/129",
                            "net:1.2.3.4.5", "net:::1::2", "net:12345::"})
    EXPECT_FALSE(SubjectPattern::parse(wrong)) << wrong;
}

TEST(Subject, CoveringIsSeen) {
  EXPECT_TRUE(covers("*", "uid:1"));
  EXPECT_TRUE(covers("uid:*", "uid:1"));
  EXPECT_FALSE(covers("uid:1", "uid:*"));
  EXPECT_TRUE(covers("net:10.0.0.0/8", "net:10.9.0.0/16"));
  EXPECT_FALSE(covers("net:10.9.0.0/16", "net:10.0.0.0/8"));
}

TEST(Subject, MistakesAreNamed) {
  EXPECT_NE(SubjectPattern::problem("usr:guest").find("did you mean user:"), std::string::npos);
  EXPECT_NE(SubjectPattern::problem("other-robots").find("did you mean other-robot?"),
            std::string::npos);
  EXPECT_NE(SubjectPattern::problem("role:boss").find("subsystem, system or top"),
            std::string::npos);
  EXPECT_NE(SubjectPattern::problem("unit:*x").find("only at the end"), std::string::npos);
}

}  // namespace tims::policy::subject_test
