#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/load.h"

namespace tims::config {
namespace check_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

const Host kHost{.name = "robot1", .uid = 0, .environment = {}};
const std::string kOpen = "[security]\ninsecure = true\n";

// All problems reported for `text`, which is preceded by two lines.
std::vector<std::string> problems(const std::string& text, std::vector<std::string> settings = {}) {
  const Loaded loaded = load({{{"r.toml", kOpen + text}}, std::move(settings), kHost});
  std::vector<std::string> texts;
  texts.reserve(loaded.problems.size());
  for (const Problem& problem : loaded.problems) texts.push_back(problem.to_string());
  return texts;
}

constexpr std::string_view kSuper = "[[link]]\nkind = \"super\"\nto = \"10.9.1.1\"\n";
constexpr std::string_view kSub = "[[link]]\nkind = \"sub\"\nsystem = 1\n";
constexpr std::string_view kPeer = "[[link]]\nkind = \"peer\"\nto = \"robot2\"\n";
std::string operator+(std::string_view a, std::string_view b) { return std::string(a).append(b); }

TEST(Check, GoodTreesAreGood) {
  EXPECT_THAT(problems("[router]\nrole = \"subsystem\"\n" + kSuper), testing::IsEmpty());
  EXPECT_THAT(problems("[router]\nrole = \"system\"\nsystem = 1\n" + kSuper + kSub + kPeer),
              testing::IsEmpty());
  EXPECT_THAT(problems("[router]\nrole = \"top\"\n" + kSub + "[[link]]\nkind = \"sub\"\n"),
              testing::IsEmpty());
  EXPECT_THAT(problems("[[link]]\nkind = \"peer\"\nsystem = 2\n"), testing::IsEmpty());
  EXPECT_THAT(problems("[[link]]\nkind = \"peer\"\nsystem = \"*\"\n"), testing::IsEmpty());
}

TEST(Check, OriginsOfPages) {
  EXPECT_THAT(problems("[http]\norigins = \"http://robot7:3000, https://[::1]\"\n"),
              testing::IsEmpty());
  for (const auto* wrong : {"robot7", "ftp://robot7", "http://", "http://robot7/", "http://*",
                            "null", "http://evil@robot7"})
    EXPECT_THAT(problems("[http]\norigins = \"http://a, " + std::string(wrong) + "\"\n"),
                ElementsAre(testing::HasSubstr("\"" + std::string(wrong) +
                                               "\" is not the origin of a web page: write")))
        << wrong;
}

TEST(Check, NamesOfThisHost) {
  EXPECT_THAT(problems("[http]\nnames = \"robot7.local, robot7\"\n"), testing::IsEmpty());
  EXPECT_THAT(problems("[http]\nnames = [\"robot7.local\", \"Robot_7-b\"]\n"), testing::IsEmpty());
  for (const auto* wrong : {"http://robot7", "robot7:8080", "*", "robot7/", "a b", "[::1]"})
    EXPECT_THAT(problems("[http]\nnames = \"a, " + std::string(wrong) + "\"\n"),
                ElementsAre(testing::HasSubstr("\"" + std::string(wrong) +
                                               "\" is not the name of a host: write")))
        << wrong;
}

TEST(Check, ALinkHasAKind) {
  EXPECT_THAT(
      problems("[[link]]\nto = \"robot2\"\n"),
      ElementsAre("r.toml:3:1: a link needs a kind: write kind = \"super\", \"peer\" or \"sub\""));
}

TEST(Check, OneSideConnects) {
  EXPECT_THAT(problems("[[link]]\nkind = \"super\"\n"),
              ElementsAre("r.toml:3:1: a super link needs the super router's host and port: write "
                          "to = \"10.9.1.1:2010\""));
  EXPECT_THAT(problems("[[link]]\nkind = \"sub\"\nto = \"robot2\"\n"),
              ElementsAre("r.toml:5:6: link.to does not fit kind = \"sub\": the routers below "
                          "connect, and this side accepts. Remove it, or write kind = \"super\""));
  for (const std::string_view link : {kSuper, kPeer})
    for (const std::string_view system : {"1", "\"*\""})
      EXPECT_THAT(
          problems(link + "system = " + system + "\n"),
          ElementsAre("r.toml:6:10: link.system selects the routers this side accepts, but on this "
                      "link it connects: remove it"))
          << link;
}

TEST(Check, DdsNeedsAFleet) {
  const std::string automatic = "[[link]]\nkind = \"super\"\nto = \"auto\"\n";
  EXPECT_THAT(problems(automatic),
              ElementsAre("r.toml:5:6: link.to \"auto\" needs the name of the fleet: write name = "
                          "\"...\" under [fleet]"));
  if (!kHasDds) {
    EXPECT_THAT(
        problems("[fleet]\nname = \"harbour\"\n"),
        ElementsAre("r.toml:4:8: fleet.name needs DDS, but this router was built without it "
                    "(TIMS_WITH_DDS=OFF): remove it, or install a router with DDS"));
    return;
  }
  EXPECT_THAT(
      problems(kSub + "paths = [\"dds\"]\n"),
      ElementsAre("r.toml:6:9: link.paths with \"dds\" needs the name of the fleet: write name "
                  "= \"...\" under [fleet]"));
  const std::string fleet = "[fleet]\nname = \"harbour\"\n";
  EXPECT_THAT(problems(fleet + automatic + kSub), testing::IsEmpty());
  EXPECT_THAT(problems(fleet + automatic, {"security.insecure=false"}), testing::IsEmpty());
  EXPECT_THAT(problems(fleet + "[[link]]\nkind = \"peer\"\nto = \"auto\"\n"),
              ElementsAre("r.toml:7:6: link.to \"auto\" finds super routers only: write the other "
                          "router's host and port, or kind = \"super\""));
  EXPECT_THAT(problems(fleet + "[udp]\nlisten = \"off\"\n" + kSub + "paths = [\"dds\"]\n"),
              testing::IsEmpty());
}

TEST(Check, AnAddressIsOneOfUdp) {
  if (!kHasDds) GTEST_SKIP() << "built without DDS";
  const std::string fleet = "[fleet]\nname = \"harbour\"\n";
  const std::string dds = "paths = [\"dds\"]\n";
  const std::string both = "paths = [\"udp\", \"dds\"]\n";
  const std::string other = "[[link]]\nkind = \"super\"\nto = \"10.9.1.2\"\n";
  EXPECT_THAT(problems(fleet + kPeer + dds),
              ElementsAre("r.toml:8:9: link.paths with \"dds\" alone cannot reach "
                          "\"robot2:2010\", which is a UDP address: write paths = [\"udp\", "
                          "\"dds\"]"));
  EXPECT_THAT(problems(fleet + kPeer + both), testing::IsEmpty());
  EXPECT_THAT(problems(fleet + "[[link]]\nkind = \"peer\"\n" + dds), testing::IsEmpty());
  EXPECT_THAT(problems(fleet + kSuper + dds + kPeer), testing::IsEmpty());
  EXPECT_THAT(problems(fleet + kSuper + dds + other),
              ElementsAre(StartsWith("r.toml:8:9: link.paths with \"dds\" alone cannot reach "
                                     "\"10.9.1.1:2010\"")));
  EXPECT_THAT(problems(fleet + kSuper + both + other), testing::IsEmpty());
}

TEST(Check, WhereDdsLooksIsNumeric) {
  EXPECT_THAT(problems("", {"dds.peers=10.9.1.1, [::1]:7410,10.9.1.2:7410"}), testing::IsEmpty());
  EXPECT_THAT(problems("", {"dds.peers=10.9.1.1,base"}),
              ElementsAre("--set 1: dds.peers must be numeric addresses such as \"10.9.1.1, "
                          "10.9.1.2:7410\", not \"base\""));
  EXPECT_THAT(problems("", {"dds.server=10.9.1.1"}),
              ElementsAre("--set 1: dds.server must be a numeric address and port such as "
                          "\"10.9.1.1:11811\", not \"10.9.1.1\""));
}

TEST(Check, TheRoleFitsTheLinks) {
  EXPECT_THAT(problems("[router]\nrole = \"top\"\nsystem = 3\n"),
              ElementsAre(StartsWith("r.toml:5:10: router.system 3 does not fit role = \"top\"")));
  EXPECT_THAT(problems("[router]\nrole = \"top\"\n" + kSuper),
              ElementsAre("r.toml:6:8: a router with role = \"top\" has no super router: remove "
                          "the link, or write role = \"system\" under [router]"));
  EXPECT_THAT(
      problems("[router]\nrole = \"subsystem\"\n" + kSub + kPeer),
      ElementsAre(
          "r.toml:6:8: a router with role = \"subsystem\" has super links only, not \"sub\": "
          "remove the link, or write role = \"system\" under [router]",
          StartsWith("r.toml:9:8: a router with role = \"subsystem\" has super links only, not "
                     "\"peer\"")));
}

TEST(Check, TwoLinksToOneRouterAreOneTooMany) {
  EXPECT_THAT(
      problems(kSuper + "[[link]]\nkind = \"peer\"\nto = \"10.9.1.1:2010\"\n"),
      ElementsAre("r.toml:8:6: link \"10.9.1.1:2010\" is already configured at r.toml:3: remove "
                  "one of them"));
  EXPECT_THAT(
      problems(std::string(kPeer), {"link=kind=peer,to=ROBOT2"}),
      ElementsAre(StartsWith("--set 1: link \"robot2:2010\" is already configured at r.toml:3")));
  EXPECT_THAT(problems(kPeer + "[[link]]\nkind = \"peer\"\nto = \"robot2:2011\"\n"),
              testing::IsEmpty());
  EXPECT_THAT(
      problems(kSub + kSub),
      ElementsAre(StartsWith("r.toml:6:1: link \"sub of system 1\" is already configured")));
  EXPECT_THAT(problems(kSub + "[[link]]\nkind = \"peer\"\nsystem = 1\n"), testing::IsEmpty());
}

TEST(Check, LinksOverTcp) {
  const std::string tcp = "paths = [\"tcp\"]\n";
  const std::string off = "[udp]\nlisten = \"off\"\n";
  EXPECT_THAT(problems(kSuper + tcp), testing::IsEmpty());
  EXPECT_THAT(problems(off + kSuper + tcp), testing::IsEmpty()) << "it only connects";
  EXPECT_THAT(problems(kSub + tcp), testing::IsEmpty());
  EXPECT_THAT(problems(off + kSub + tcp),
              ElementsAre(HasSubstr("udp.listen \"off\" leaves nothing for the link")));
}

TEST(Check, LinksNeedUdp) {
  EXPECT_THAT(problems("[udp]\nlisten = \"off\"\n"), testing::IsEmpty());
  EXPECT_THAT(problems("[udp]\nlisten = \"off\"\n" + kSub),
              ElementsAre(StartsWith(
                  "r.toml:4:10: udp.listen \"off\" leaves nothing for the link to run over, the "
                  "first of r.toml:5: write listen = ")));
  EXPECT_THAT(
      problems(kSub + kPeer, {"udp.listen=off"}),
      ElementsAre(StartsWith("--set 1: udp.listen \"off\" leaves nothing for the 2 links")));
}

TEST(Check, LinksBeyondLoopbackMustBeWanted) {
  const std::vector<std::string> closed{"security.insecure=false"};
  EXPECT_THAT(problems("[udp]\nlisten = \"0.0.0.0:2010\"\n", closed),
              ElementsAre(StartsWith("r.toml:4:10: udp.listen \"0.0.0.0:2010\" is not a loopback "
                                     "address, and this router has no keys: ")));
  EXPECT_THAT(problems(kSuper + kPeer, closed),
              ElementsAre("r.toml:5:6: link.to \"10.9.1.1:2010\" is not a loopback address, and "
                          "this router has no keys: any program that can reach the port "
                          "could command the robot, because udp.listen would have to be beyond "
                          "loopback too. Link to \"127.0.0.1:2010\"; or, where every machine of "
                          "the network is trusted, write \"insecure = true\" under [security] (or "
                          "--set security.insecure=true)",
                          StartsWith("r.toml:8:6: link.to \"robot2:2010\" is not a loopback")));
  EXPECT_THAT(problems("[[link]]\nkind = \"super\"\nto = \"localhost:2011\"\n" + kSub, closed),
              testing::IsEmpty());
}

TEST(Check, NumbersFitIntoTheirBits) {
  EXPECT_THAT(
      problems("[address]\nwidths = \"4/12/4/12\"\n[router]\nsystem = 16\nid = 255\n[[link]]\nkind "
               "= \"sub\"\nsystem = 99\n"),
      ElementsAre(
          "r.toml:6:10: router.system 16 does not fit into the 4 bits of system of address.widths: "
          "write at most 15, or wider fields for the whole fleet, such as widths = \"12/8/6/6\" "
          "under [address]",
          StartsWith("r.toml:7:6: router.id 255 does not fit into the 4 bits of instance"),
          StartsWith("r.toml:10:10: link.system 99 does not fit into the 4 bits of system")));
}

TEST(Check, AThousandRobotsHaveASystemEach) {
  const auto with = [&](int system, int id) {
    return problems(
        fmt::format("[address]\nwidths = \"12/8/6/6\"\n[router]\nsystem = {}\nid = {}\n"
                    "[[link]]\nkind = \"sub\"\nsystem = {}\n",
                    system, id, system));
  };
  EXPECT_THAT(with(1000, 63), testing::IsEmpty());
  EXPECT_THAT(with(4095, 0), testing::IsEmpty());
  EXPECT_EQ(with(4096, 63).size(), 2U);
  EXPECT_EQ(with(1000, 64).size(), 1U);
  EXPECT_THAT(problems("[router]\nsystem = 256\n"),
              ElementsAre(HasSubstr("router.system 256 does not fit into the 8 bits")));
}

TEST(Check, RoutesAreWholeAndTheirPatternsReadable) {
  EXPECT_THAT(problems("[[route]]\nmatch = \"*(2/*)\"\nvia = \"robot2\"\n"), testing::IsEmpty());
  EXPECT_THAT(problems("[[route]]\n"),
              ElementsAre("r.toml:3:1: a route needs match: write match = \"Ladar(3/*)\"",
                          "r.toml:3:1: a route needs via: write via = \"robot2\", the name of the "
                          "router to go through"));
  EXPECT_THAT(
      problems("[[route]]\nmatch = \"Lader(3/*)\"\nvia = \"robot2\"\n"),
      ElementsAre("r.toml:4:9: route.match must be an address pattern such as \"Ladar(3/*)\", "
                  "\"*(2/*)\" or \"0x03140000\", not \"Lader(3/*)\""));
  const std::string route = "[[route]]\nmatch = \"Ladar(99/*)\"\nvia = \"robot2\"\n";
  EXPECT_THAT(problems("[address]\nwidths = \"4/12/8/8\"\n" + route),
              ElementsAre(StartsWith("r.toml:6:9: route.match must be an address pattern")));
  EXPECT_THAT(
      problems(route + route),
      ElementsAre(StartsWith("r.toml:6:1: the same route is already configured at r.toml:3")));
}

TEST(Check, ConsequencesOfAnotherMistakeAreNotReported) {
  EXPECT_THAT(problems("[[link]]\nknd = \"super\"\nto = \"robot2\"\n"),
              ElementsAre("r.toml:4:1: unknown key link.knd; did you mean link.kind?"));
  EXPECT_THAT(problems("[[link]]\nkind = \"super\"\nto = \"no where\"\n"),
              ElementsAre(StartsWith("r.toml:5:6: link.to must be a host and port such as")));
  EXPECT_THAT(problems("[[link]]\nkind = \"upper\"\nto = \"robot2\"\nsystem = 1\n"),
              ElementsAre("r.toml:4:8: link.kind must be \"super\", \"peer\" or \"sub\", not "
                          "\"upper\""));
  EXPECT_THAT(
      problems("[router]\nrole = \"robot\"\n" + kSub),
      ElementsAre("r.toml:4:8: router.role must be \"subsystem\", \"system\" or \"top\", not "
                  "\"robot\""));
  EXPECT_THAT(problems("[address]\nwidths = \"4/12/8/9\"\n[[route]]\nmatch = "
                       "\"Ladar(99/*)\"\nvia = \"robot2\"\n"),
              ElementsAre(StartsWith("r.toml:4:10: address.widths \"4/12/8/9\" does not add up")));
}

TEST(Check, AnErrorBesideARefusedValueHasItsPlace) {
  EXPECT_THAT(problems("[[link]]\nkind = \"sub\"\nto = \"no where\"\n"),
              ElementsAre(StartsWith("r.toml:5:6: link.to must be"),
                          StartsWith("r.toml:5:6: link.to does not fit kind = \"sub\"")));
}

TEST(Check, OldListsAreRefusedOnlyWhenAnyIsOld) {
  const auto problem = [](const std::string& more) {
    const Loaded loaded =
        load({{{"r.toml", "[security]\nrefuse_old_list = true\n" + more}}, {}, kHost});
    return loaded.ok() ? "" : loaded.problems.front().to_string();
  };
  EXPECT_THAT(problem(""), HasSubstr("no list is old without security.list_age_max"));
  EXPECT_EQ(problem("list_age_max = \"72h\"\n"), "");
}

// With keys, DDS leaves the host only where that is wanted, and then its faults are named.
TEST(Check, DdsBeyondTheHost) {
  const auto loaded = [](const std::string& text) {
    return load({{{"r.toml", text + "[fleet]\nname = \"harbour\"\n" + kSuper}}, {}, kHost});
  };
  constexpr std::string_view kKeys = "[security]\nkeys = \"/etc/tims/keys\"\n";
  constexpr std::string_view kBeyond = "[dds]\nbeyond_host = true\n";

  const Loaded closed = loaded(kKeys + std::string());
  ASSERT_TRUE(closed.ok());
  EXPECT_FALSE(closed.config.dds_leaves_host());
  EXPECT_THAT(closed.config.links[0].paths, ElementsAre(PathKind::kUdp));
  EXPECT_THAT(cautions(closed.config), testing::IsEmpty());

  const Loaded open = loaded(kKeys + std::string(kBeyond));
  ASSERT_TRUE(open.ok());
  EXPECT_TRUE(open.config.dds_leaves_host());
  EXPECT_THAT(cautions(open.config),
              ElementsAre(testing::AllOf(HasSubstr("Fast DDS"), HasSubstr("CVE-2025-62799"),
                                         HasSubstr("dds.beyond_host = false"))));
  if (kHasDds) {
    EXPECT_THAT(open.config.links[0].paths, ElementsAre(PathKind::kUdp, PathKind::kDds));
  }

  const Loaded without_keys = loaded(kOpen);
  ASSERT_TRUE(without_keys.ok());
  EXPECT_TRUE(without_keys.config.dds_leaves_host());
  EXPECT_THAT(cautions(without_keys.config),
              ElementsAre(HasSubstr("security.insecure = false, or fleet.name")));
  EXPECT_THAT(loaded(std::string(kBeyond)).problems.front().to_string(),
              HasSubstr("dds.beyond_host = true without keys"));
}

}  // namespace check_test
}  // namespace tims::config
