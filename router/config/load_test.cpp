#include "router/config/load.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/options.h"
#include "tests/support/temporary_folder.h"

namespace tims::config {
namespace load_test {

using namespace std::chrono_literals;

const Host kHost{.name = "robot1", .uid = 0, .environment = {{"ID", "7"}, {"ON", "true"}}};

Loaded load_text(std::string text, std::vector<std::string> settings = {}) {
  return load({{{"r.toml", std::move(text)}}, std::move(settings), kHost});
}

std::vector<std::string> problems_of(const Loaded& loaded) {
  std::vector<std::string> texts;
  texts.reserve(loaded.problems.size());
  for (const Problem& problem : loaded.problems) texts.push_back(problem.to_string());
  return texts;
}

Config good(std::string text, std::vector<std::string> settings = {}) {
  const Loaded loaded = load_text(std::move(text), std::move(settings));
  EXPECT_THAT(problems_of(loaded), testing::IsEmpty());
  return loaded.config;
}

TEST(Settings, AListInAnItemHasAPlusBetweenItsElements) {
  const Loaded loaded =
      load({{},
            {"rule=name=a,from=uid:1+uid:2,types=drive+look,then=allow", "rule=name=b,then=deny"},
            kHost});
  ASSERT_TRUE(loaded.ok()) << loaded.problems.front().to_string();
  ASSERT_EQ(loaded.config.rules.size(), 2U);
  EXPECT_EQ(loaded.config.rules[0].from, "uid:1, uid:2");
  EXPECT_EQ(loaded.config.rules[0].types, "drive, look");
}

TEST(Load, NothingWrittenGivesTheDefaults) {
  EXPECT_EQ(good(""), defaults(kHost));
  EXPECT_EQ(good("# only a comment\n[tcp]\n"), defaults(kHost));
}

TEST(Load, ReadsEveryKindOfValue) {
  const Config config = good(R"(
[router]
name = "${HOSTNAME}-front"
system = 3
id = 255
[unix]
path = "/tmp/x.sock"
[tcp]
listen = "localhost:2001"
compat_delete = true
queue = 65536
[http]
listen = "off"
[message]
max = "262144B"
[lifesign]
interval = "250ms"
[limits]
clients = 3
mailboxes_per_client = 4
[log]
level = "debug"
)");
  EXPECT_EQ(config.router.name, "robot1-front");
  EXPECT_EQ(config.router.system, 3);
  EXPECT_EQ(config.router.id, 255);
  EXPECT_EQ(config.unix.path, "/tmp/x.sock");
  EXPECT_EQ(config.tcp.listen, (Endpoint{"127.0.0.1", 2001}));
  EXPECT_TRUE(config.tcp.compat_delete);
  EXPECT_EQ(config.tcp.queue_bytes, 65536U);
  EXPECT_EQ(config.http.listen, std::nullopt);
  EXPECT_EQ(config.message.bytes_max, 262144U);
  EXPECT_EQ(config.lifesign.interval, 250ms);
  EXPECT_EQ(config.limits.clients, 3U);
  EXPECT_EQ(config.limits.mailboxes_per_client, 4U);
  EXPECT_EQ(config.log.level, LogLevel::kDebug);
}

TEST(Load, DottedKeysAndInlineTablesAreTheSame) {
  EXPECT_EQ(good("tcp.listen = \"off\"\n"), good("tcp = { listen = \"off\" }\n"));
}

TEST(Load, LaterFilesAndSettingsWinKeyByKey) {
  const Loaded loaded =
      load({{{"a.toml", "[router]\nsystem = 1\nid = 1\n[log]\nlevel = \"error\"\n"},
             {"b.toml", "[router]\nid = 2\n[log]\nlevel = \"info\"\n"}},
            {"log.level=debug", "router.name=\"x\"", "log.level=warning"},
            kHost});
  EXPECT_THAT(problems_of(loaded), testing::IsEmpty());
  EXPECT_EQ(loaded.config.router.system, 1);
  EXPECT_EQ(loaded.config.router.id, 2);
  EXPECT_EQ(loaded.config.router.name, "x");
  EXPECT_EQ(loaded.config.log.level, LogLevel::kWarning);
  EXPECT_EQ(loaded.origins.at("router.system").to_string(), "a.toml:2");
  EXPECT_EQ(loaded.origins.at("router.id").to_string(), "b.toml:2");
  EXPECT_EQ(loaded.origins.at("log.level").to_string(), "--set 3");
  EXPECT_FALSE(loaded.origins.contains("tcp.listen"));
}

TEST(Load, NumbersAndFlagsMayComeFromTheEnvironment) {
  const Config config = good("[router]\nid = \"${ID}\"\n[tcp]\ncompat_delete = \"${ON}\"\n");
  EXPECT_EQ(config.router.id, 7);
  EXPECT_TRUE(config.tcp.compat_delete);
}

TEST(Load, TheSocketLiesWhereThisUserMayPutIt) {
  EXPECT_EQ(defaults({.name = "h", .uid = 0, .environment = {{"XDG_RUNTIME_DIR", "/x"}}}).unix.path,
            "/run/tims/router.sock");
  EXPECT_EQ(defaults({.name = "h", .uid = 5, .environment = {{"XDG_RUNTIME_DIR", "/x"}}}).unix.path,
            "/x/tims/router.sock");
  EXPECT_EQ(defaults({.name = "h", .uid = 5, .environment = {{"XDG_RUNTIME_DIR", ""}}}).unix.path,
            "/tmp/tims-5/router.sock");
  EXPECT_EQ(defaults({.name = "h", .uid = 5, .environment = {}}).unix.path,
            "/tmp/tims-5/router.sock");
}

TEST(Load, ADefaultThatDoesNotFitIsAnError) {
  const Host host{
      .name = "h", .uid = 5, .environment = {{"XDG_RUNTIME_DIR", "/" + std::string(100, 'x')}}};
  const Loaded loaded = load({{}, {}, host});
  EXPECT_THAT(problems_of(loaded),
              testing::ElementsAre(testing::StartsWith("default: unix.path \"/xxx")));
  EXPECT_TRUE(load({{}, {"unix.path=/tmp/short"}, host}).ok());
}

// One row of the table: a configuration text, and all problems reported for it.
struct Bad {
  std::string_view text;
  std::vector<std::string> problems;
};

const std::vector<Bad> kBad{
    // Names.
    {"[tcp]\nlistn = \"off\"\n", {"r.toml:2:1: unknown key tcp.listn; did you mean tcp.listen?"}},
    {"[tcp]\n  level = \"info\"\n", {"r.toml:2:3: unknown key tcp.level; did you mean log.level?"}},
    {"listen = \"off\"\n",
     {"r.toml:1:1: unknown key listen; did you mean tcp.listen or http.listen or udp.listen?"}},
    {"[tcp]\nflux = 1\n", {"r.toml:2:1: unknown key tcp.flux"}},
    {"[tpc]\nlisten = 5\nqueue = 6\n", {"r.toml:1:2: unknown table [tpc]; did you mean [tcp]?"}},
    {"[flux]\n",
     {"r.toml:1:2: unknown table [flux]; known are router, address, unix, tcp, http, udp, "
      "fleet, dds, message, lifesign, limits, newest, log, security, sim, link, route, rule, "
      "test"}},
    {"[tcp.listen]\nport = 3\n",
     {"r.toml:1:1: tcp.listen must be a numeric address and port such as \"127.0.0.1:2000\", "
      "\"0.0.0.0:2000\" (all interfaces) or \"[::1]:2000\", or \"off\", not a table"}},
    {"tcp = 5\n", {"r.toml:1:1: tcp is a table: write [tcp] once, above its keys"}},
    {"[[tcp]]\nqueue = 5\n", {"r.toml:1:1: tcp is a table: write [tcp] once, above its keys"}},
    // Lists.
    {"[link]\nkind = \"super\"\n",
     {"r.toml:1:2: link is a list: write [[link]] above the keys of each link"}},
    {"link.to = \"robot2\"\n",
     {"r.toml:1:1: link is a list: write [[link]] above the keys of each link"}},
    {"link = []\n", {"r.toml:1:1: link is a list: write [[link]] above the keys of each link"}},
    {"[links]\nkind = 3\n", {"r.toml:1:2: unknown table [links]; did you mean [[link]]?"}},
    {"[[lnik]]\nkind = 3\n", {"r.toml:1:1: unknown table [[lnik]]; did you mean [[link]]?"}},
    {"[[link]]\nkind = \"sub\"\nrats = 5\n[[link]]\nkind = \"peer\"\nflux = 1\n",
     {"r.toml:3:1: unknown key link.rats; did you mean link.rate?",
      "r.toml:6:1: unknown key link.flux; known are kind, to, system, paths, name, mailboxes, "
      "interval, rate, reserve, lifetime, compress, compress_own, secure"}},
    {"[[link]]\nkind = \"sub\"\nsystem = 65536\nrate = 9999\ninterval = \"11s\"\nreserve = 91\n",
     {"r.toml:3:10: link.system 65536 is out of range (0 to 65535)",
      "r.toml:4:8: link.rate 9999B is out of range (10kB to 100GB, or 0)",
      "r.toml:5:12: link.interval 11s is out of range (50ms to 10s)",
      "r.toml:6:11: link.reserve 91 is out of range (0 to 90)"}},
    {"[[link]]\nkind = \"sub\"\nsystem = \"1\"\n",
     {R"(r.toml:3:10: link.system must be a system's number or "*" for any, not the text "1")"}},
    {"[[link]]\nkind = \"sub\"\n[link.to]\nhost = 5\n",
     {"r.toml:3:1: link.to must be a host and port such as \"10.9.1.1:2010\", \"robot1:2010\" or "
      "\"[fd00::1]:2010\", not a table",
      "r.toml:3:1: link.to does not fit kind = \"sub\": the routers below connect, and this side "
      "accepts. Remove it, or write kind = \"super\""}},
    {"[[tcp]]\n[zz]\na = 1\n[tcp.sub]\nb = 2\n",
     {"r.toml:1:1: tcp is a table: write [tcp] once, above its keys",
      "r.toml:2:2: unknown table [zz]; known are router, address, unix, tcp, http, udp, fleet, "
      "dds, message, "
      "lifesign, limits, newest, log, security, sim, link, route, rule, test"}},
    // Types.
    {"[router]\nid = \"3\"\n",
     {"r.toml:2:6: router.id must be a whole number, not the text \"3\""}},
    {"[router]\nid = 3.0\n",
     {"r.toml:2:6: router.id must be a whole number, not a number with a fraction"}},
    {"[router]\nid = true\n", {"r.toml:2:6: router.id must be a whole number, not true"}},
    {"[router]\nid = [1]\n", {"r.toml:2:6: router.id must be a whole number, not an array"}},
    {"[router]\nid = 1979-05-27\n",
     {"r.toml:2:6: router.id must be a whole number, not a date or time"}},
    {"[router]\nname = 3\n", {"r.toml:2:8: router.name must be a text such as \"robot1\", not 3"}},
    {"[tcp]\ncompat_delete = 1\n", {"r.toml:2:17: tcp.compat_delete must be true or false, not 1"}},
    {"[tcp]\ncompat_delete = \"true\"\n",
     {"r.toml:2:17: tcp.compat_delete must be true or false, not the text \"true\""}},
    {"[lifesign]\ninterval = 5\n",
     {"r.toml:2:12: lifesign.interval must be a duration with its unit such as \"250ms\" or "
      "\"5s\", "
      "not 5"}},
    {"[log]\nlevel = \"loud\"\n",
     {R"(r.toml:2:9: log.level must be "error", "warning", "info" or "debug", not "loud")"}},
    // Units and ranges.
    {"[lifesign]\ninterval = \"5 s\"\n",
     {"r.toml:2:12: lifesign.interval has the unknown unit \" s\" in \"5 s\"; known are ns, us, "
      "ms, s, min, h"}},
    {"[lifesign]\ninterval = \"99ms\"\n",
     {"r.toml:2:12: lifesign.interval 99ms is out of range (100ms to 1h)"}},
    {"[router]\nsystem = 65536\nid = -1\n",
     {"r.toml:2:10: router.system 65536 is out of range (0 to 65535)",
      "r.toml:3:6: router.id -1 is out of range (0 to 65535)"}},
    {"[message]\nmax = 65535\n",
     {"r.toml:2:7: message.max 65535B is out of range (64KiB to 1GiB)"}},
    {"[message]\nmax = \"2GiB\"\n",
     {"r.toml:2:7: message.max 2GiB is out of range (64KiB to 1GiB)"}},
    {"[unix]\npath = \"\"\n", {"r.toml:2:8: unix.path \"\" is out of range (1 to 107 bytes long)"}},
    {"[[link]]\nkind = \"sub\"\npaths = [\"udp\", \"ipx\"]\n",
     {"r.toml:3:9: link.paths has the unknown path \"ipx\"; known are \"udp\", \"dds\" and "
      "\"tcp\""}},
    {"[[link]]\nkind = \"sub\"\npaths = [\"udp\", \"udp\"]\n",
     {"r.toml:3:9: link.paths has \"udp\" twice"}},
    {"[[link]]\nkind = \"sub\"\npaths = []\n",
     {"r.toml:3:9: link.paths must be a list of paths such as [\"udp\", \"dds\"], not an array"}},
    {"[tcp]\nlisten = [\"127.0.0.1:2000\"]\n",
     {"r.toml:2:10: tcp.listen must be a numeric address and port such as \"127.0.0.1:2000\", "
      "\"0.0.0.0:2000\" (all interfaces) or \"[::1]:2000\", or \"off\", not an array"}},
    // Variables.
    {"[router]\nname = \"${NOBODY}\"\n",
     {"r.toml:2:8: router.name names the environment variable NOBODY, which is not set"}},
    {"[router]\nid = \"${HOSTNAME}\"\n",
     {"r.toml:2:6: router.id must be a whole number, not \"robot1\""}},
};

TEST(Load, BadConfigurationsAreReportedWithLineAndColumn) {
  for (const Bad& bad : kBad)
    EXPECT_EQ(problems_of(load_text(std::string(bad.text))), bad.problems) << bad.text;
}

TEST(Load, ProblemsComeInTheOrderOfTheText) {
  EXPECT_THAT(problems_of(load_text("z = 1\n[tcp]\nqueu = 2\nlisten = \"x\"\n[lok]\n")),
              testing::ElementsAre(testing::StartsWith("r.toml:1:1: unknown key z"),
                                   testing::StartsWith("r.toml:3:1: unknown key tcp.queu"),
                                   testing::StartsWith("r.toml:4:10: tcp.listen must be"),
                                   testing::StartsWith("r.toml:5:2: unknown table [lok]")));
  // Keys of one table may be scattered over a file.
  EXPECT_THAT(
      problems_of(load_text("tcp.queu = 1\nlog.lvl = 2\ntcp.lisen = 3\n")),
      testing::ElementsAre(testing::StartsWith("r.toml:1:5"), testing::StartsWith("r.toml:2:5"),
                           testing::StartsWith("r.toml:3:5")));
}

TEST(Load, KnowsWhereValuesStand) {
  EXPECT_THAT(problems_of(load_text("[tcp]\n  queue =  \"4 apples\"\n")),
              testing::ElementsAre(testing::StartsWith("r.toml:2:12: tcp.queue")));
}

TEST(Load, WhatLiesDeeperIsAValueThatNoneTakes) {
  EXPECT_THAT(problems_of(load_text("[tcp.listen]\na = 1\nb = 2\n")),
              testing::ElementsAre(testing::EndsWith(", not a table")));
  EXPECT_THAT(problems_of(load_text("[tcp]\nlisten = [{c = 1}]\n")),
              testing::ElementsAre(testing::EndsWith(", not an array of tables")));
  for (const auto& [value, what] :
       {std::pair("[1, 2]", "an array"), std::pair("[{a = 1}, 2]", "an array"),
        std::pair("07:32:00", "a date or time"), std::pair("-1.5", "a number with a fraction")})
    EXPECT_THAT(problems_of(load_text(std::string("[tcp]\nlisten = ") + value + "\n")),
                testing::ElementsAre(testing::EndsWith(std::string(", not ") + what)));
}

TEST(Load, ItemsOfListsAreCountedHoweverTheyAreWritten) {
  for (const char* written :
       {"[[link]]\nkind = \"sub\"\na = [{c = 1}]\n[[link]]\n[[link]]\na = 2\n",
        "link = [{kind = \"sub\", a = [{c = 1}]}, {}, {a = 2}]\n"}) {
    const Loaded loaded = load_text(written);
    EXPECT_EQ(loaded.config.links.size(), 3U);
    EXPECT_TRUE(loaded.origins.contains("link[0].kind"));
    EXPECT_TRUE(loaded.origins.contains("link[2]"));
  }
  EXPECT_EQ(load_text("\n[[link]]\n").origins.at("link[0]").to_string(), "r.toml:2");
}

TEST(Load, ATextThatIsNotTomlGivesNothingButItsProblem) {
  const Loaded loaded = load_text("[tcp]\nqueue = \"8MiB\"\nb = \n");
  EXPECT_EQ(loaded.config.tcp, defaults(kHost).tcp);
  ASSERT_EQ(loaded.problems.size(), 1U);
  EXPECT_EQ(loaded.problems[0].at.line, 3U);
}

TEST(Load, InvalidTomlIsReportedWithLineAndColumn) {
  const auto first = [](std::string text) {
    const auto problems = problems_of(load_text(std::move(text)));
    return problems.empty() ? "none" : problems.front();
  };
  EXPECT_THAT(first("[tcp]\nqueue = 5\nqueue = 6\n"), testing::StartsWith("r.toml:3:"));
  EXPECT_THAT(first("[tcp]\n[http]\n[tcp]\n"), testing::StartsWith("r.toml:3:"));
  EXPECT_THAT(first("[tcp\nqueue = 5\n"), testing::StartsWith("r.toml:1:"));
  EXPECT_THAT(first("[tcp]\nlisten = off\n"), testing::StartsWith("r.toml:2:"));
  EXPECT_THAT(first("[tcp]\nqueue = 4MiB\n"), testing::EndsWith("durations stand in quotes"));
  EXPECT_THAT(first("\n[\n"), testing::StartsWith("r.toml:2:"));
  EXPECT_THAT(first(std::string("a = \"\0\"", 7)), testing::StartsWith("r.toml:1:"));
}

TEST(Load, WhatUdpListensOnFollowsFromInsecure) {
  EXPECT_EQ(good("").udp.listen, (Endpoint{"127.0.0.1", 2010}));
  EXPECT_EQ(good("", {"security.insecure=true"}).udp.listen, (Endpoint{"0.0.0.0", 2010}));
  EXPECT_EQ(good("[udp]\nlisten = \"off\"\n", {"security.insecure=true"}).udp.listen, std::nullopt);
  EXPECT_FALSE(load_text("", {"security.insecure=true"}).origins.contains("udp.listen"));
}

TEST(Load, InAFleetLinksHaveBothPaths) {
  const LinkPaths udp{PathKind::kUdp};
  const std::string link = "[[link]]\nkind = \"sub\"\n";
  EXPECT_EQ(good(link).links[0].paths, udp);
  if (!kHasDds) GTEST_SKIP() << "built without DDS";
  const std::string fleet = "[fleet]\nname = \"harbour\"\n";
  EXPECT_EQ(good(fleet + link).links[0].paths, (LinkPaths{PathKind::kUdp, PathKind::kDds}));
  EXPECT_EQ(good(fleet + link + "paths = [\"udp\"]\n").links[0].paths, udp);
  EXPECT_EQ(good(fleet + link + "paths = [\"dds\", \"udp\"]\n").links[0].paths,
            (LinkPaths{PathKind::kDds, PathKind::kUdp}));
}

TEST(Load, ReadsTheTree) {
  const Config config = good(R"(
[router]
role = "top"
[address]
widths = "6/8/10/8"
[sim]
faults = true
)");
  EXPECT_EQ(config.router.role, Role::kTop);
  EXPECT_EQ(config.address.widths, (AddressWidths{6, 8, 10, 8}));
  EXPECT_TRUE(config.sim.faults);
}

TEST(Load, ReadsEveryKeyOfLinksAndRoutes) {
  const Config config = good(R"toml(
[[link]]
kind = "super"
to = "${HOSTNAME}"
[[link]]
kind = "sub"
system = "${ID}"
name = "arms"
interval = "50ms"
rate = "6MB"
reserve = 90
lifetime = "1h"
[[route]]
match = "Ladar(3/*)"
via = "robot2"
)toml",
                             {"security.insecure=true"});
  ASSERT_EQ(config.links.size(), 2U);
  Link first;
  first.kind = LinkKind::kSuper;
  first.host = "robot1";
  first.port = 2010;
  EXPECT_EQ(config.links[0], first);
  Link second;
  second.kind = LinkKind::kSub;
  second.system = 7;
  second.name = "arms";
  second.interval = 50ms;
  second.rate = 6'000'000;
  second.reserve = 90;
  second.lifetime = 1h;
  EXPECT_EQ(config.links[1], second);
  EXPECT_EQ(config.routes, (std::vector<Route>{{"Ladar(3/*)", "robot2"}}));
}

TEST(Load, LinksOfAllFilesAndSettingsStandOneBehindTheOther) {
  const Loaded loaded = load(
      {{{"a.toml", "[[link]]\nkind = \"super\"\nto = \"127.0.0.1:1\"\n"},
        {"b.toml", "link = [{ kind = \"super\", to = \"127.0.0.1:2\" }, { kind = \"sub\" }]\n"}},
       {"link=kind=peer,to=\"127.0.0.1:3\",rate=1MB", "route=match=Ladar(3/*),via=robot2",
        "link=kind=super,to=[::1]"},
       kHost});
  EXPECT_THAT(problems_of(loaded), testing::IsEmpty());
  std::vector<std::string> links;
  links.reserve(loaded.config.links.size());
  for (const Link& link : loaded.config.links) links.push_back(link.to_string());
  EXPECT_THAT(links, testing::ElementsAre("127.0.0.1:1", "127.0.0.1:2", "sub of *", "127.0.0.1:3",
                                          "[::1]:2010"));
  EXPECT_EQ(loaded.config.links[3].rate, 1'000'000U);
  EXPECT_EQ(loaded.config.routes.size(), 1U);
  EXPECT_EQ(loaded.origins.at("link[1].to").to_string(), "b.toml:1");
  EXPECT_EQ(loaded.origins.at("link[3]").to_string(), "--set 1");
  EXPECT_EQ(loaded.origins.at("link[3].rate").to_string(), "--set 1");
  EXPECT_EQ(loaded.origins.at("route[0].via").to_string(), "--set 2");
}

TEST(Load, AllProblemsOfAllSourcesAreReported) {
  const Loaded loaded = load({{{"a.toml", "[router]\nid = 70000\nsytem = 1\n"}, {"b.toml", "[x\n"}},
                              {"log.level=loud", "tcp.queu=5", "nonsense"},
                              kHost});
  EXPECT_THAT(
      problems_of(loaded),
      testing::ElementsAre(
          "a.toml:2:6: router.id 70000 is out of range (0 to 65535)",
          "a.toml:3:1: unknown key router.sytem; did you mean router.system?",
          testing::StartsWith("b.toml:1:"),
          "--set 1: log.level must be \"error\", \"warning\", \"info\" or \"debug\", not \"loud\"",
          "--set 2: unknown key tcp.queu; did you mean tcp.queue?",
          "--set 3: must be key=value, not \"nonsense\""));
}

TEST(Load, ItemsOnTheCommandLineAreWhole) {
  const auto setting_problems = [](std::string setting) {
    return problems_of(load_text("", {std::move(setting)}));
  };
  const std::string alone =
      "--set 1: {} cannot be set alone: write [[link]] in a file, or give a whole link as --set "
      "link='kind=super,to=10.9.1.1:2010'";
  const auto named = [&](std::string_view key) { return std::string(alone).replace(9, 2, key); };
  EXPECT_THAT(setting_problems("link.to=robot2"), testing::ElementsAre(named("link.to")));
  EXPECT_THAT(setting_problems("link[0].to=robot2"), testing::ElementsAre(named("link[0].to")));
  EXPECT_THAT(setting_problems("links=kind=sub"),
              testing::ElementsAre("--set 1: unknown key links; did you mean link?"));
  EXPECT_THAT(setting_problems("link="),
              testing::ElementsAre(testing::StartsWith("--set 1: a link needs a")));
  EXPECT_THAT(setting_problems("link=sub"),
              testing::ElementsAre("--set 1: link must be key=value,key=value, such as --set "
                                   "link='kind=super,to=10.9.1.1:2010', not \"sub\""));
  EXPECT_THAT(setting_problems("link=kind=sub,sytem=1"),
              testing::ElementsAre("--set 1: unknown key link.sytem; did you mean link.system?"));
  EXPECT_THAT(setting_problems("link=kind=sub,kind=peer"),
              testing::ElementsAre("--set 1: link.kind is given twice"));
}

TEST(Load, OptionsOfTlsAreChecked) {
  EXPECT_THAT(problems_of(load_text("[tcp]\nplain = \"robot7\"\n")),
              testing::ElementsAre(testing::StartsWith("r.toml:2:9: tcp.plain: \"robot7\" is not a "
                                                       "network")));
  EXPECT_TRUE(load_text("[tcp]\nplain = [\"loopback\", \"10.9.0.0/16\"]\n").ok());
  EXPECT_TRUE(load_text("[tcp]\nplain = \"\"\n").ok());
  EXPECT_FALSE(load_text("[http]\ncertificate = \"/c\"\n", {"security.keys=/k"}).ok());
  EXPECT_FALSE(load_text("[http]\nkey = \"/c\"\n", {"security.keys=/k"}).ok());
  EXPECT_FALSE(load_text("[http]\ncertificate = \"/c\"\nkey = \"/k\"\n").ok());
  EXPECT_TRUE(load_text("[http]\ncertificate = \"/c\"\nkey = \"/k\"\n", {"security.keys=/k"}).ok());
}

TEST(Load, ListeningBeyondLoopbackMustBeWanted) {
  const std::string open = "[tcp]\nlisten = \"0.0.0.0:2000\"\n";
  EXPECT_EQ(
      problems_of(load_text(open)),
      std::vector<std::string>{
          "r.toml:2:10: tcp.listen \"0.0.0.0:2000\" is not a loopback address, and this "
          "router has no keys: any program that can reach the port could command "
          "the robot. Make keys (timsctl key init, or timsctl join TEXT) and write their folder, "
          "keys = \"/etc/tims/keys\", under [security]; or listen on \"127.0.0.1:2000\"; or, where "
          "every machine of the network is trusted, write \"insecure = true\" under [security] (or "
          "--set security.insecure=true)"});
  EXPECT_TRUE(load_text(open, {"security.keys=/etc/tims/keys"}).ok()) << "then it is TLS";
  EXPECT_THAT(problems_of(load_text("", {"http.listen=[::]:8080"})),
              testing::ElementsAre(testing::StartsWith("--set 1: http.listen \"[::]:8080\"")));
  EXPECT_TRUE(load_text(open + "[security]\ninsecure = true\n").ok());
  EXPECT_TRUE(load_text(open, {"security.insecure=true"}).ok());
  EXPECT_TRUE(load_text("[tcp]\nlisten = \"[::1]:2000\"\n").ok());
}

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void write(const fs::path& name, std::string_view text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }

  // "name=text" of every file read.
  [[nodiscard]] std::vector<std::string> read(const fs::path& name) const {
    const auto files = read_files((folder_ / name).string());
    if (!files) return {"refused"};
    std::vector<std::string> list;
    for (const File& file : *files)
      list.push_back(fs::relative(file.name, folder_).string() + "=" + file.text);
    return list;
  }

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(Files, AFileAlone) {
  write("router.toml", "a");
  EXPECT_THAT(read("router.toml"), testing::ElementsAre("router.toml=a"));
}

TEST_F(Files, AFileAndTheFolderBesideItInOrder) {
  write("router.toml", "a");
  write("router.d/20-b.toml", "c");
  write("router.d/10-a.toml", "b");
  write("router.d/notes.txt", "no");
  write("other.d/x.toml", "no");
  EXPECT_THAT(read("router.toml"), testing::ElementsAre("router.toml=a", "router.d/10-a.toml=b",
                                                        "router.d/20-b.toml=c"));
}

TEST_F(Files, AFolder) {
  write("b.toml", "2");
  write("a.toml", "1");
  EXPECT_THAT(read("."), testing::ElementsAre("a.toml=1", "b.toml=2"));
}

TEST_F(Files, AFileThatIsNotThereIsAnErrorThatNamesIt) {
  const auto files = read_files(folder_ / "no.toml");
  ASSERT_FALSE(files.ok());
  EXPECT_EQ(files.error().detail(),
            "cannot read " + (folder_ / "no.toml").string() + ": No such file or directory");
}

const Environment kEnvironment{{"HOSTNAME", "robot1"}, {"EMPTY", ""}, {"NESTED", "${HOSTNAME}"}};

std::string replaced(std::string_view text) {
  const auto result = substitute(text, kEnvironment);
  return result ? *result : "refused: " + result.error().detail();
}

TEST(Substitute, ReplacesVariables) {
  EXPECT_EQ(replaced("${HOSTNAME}"), "robot1");
  EXPECT_EQ(replaced("/run/${HOSTNAME}/${HOSTNAME}.sock"), "/run/robot1/robot1.sock");
  EXPECT_EQ(replaced("a${EMPTY}b"), "ab");
}

TEST(Substitute, LeavesOtherTextAlone) {
  EXPECT_EQ(replaced(""), "");
  EXPECT_EQ(replaced("plain {text}"), "plain {text}");
  EXPECT_EQ(replaced("$HOSTNAME costs 5$"), "$HOSTNAME costs 5$");
}

TEST(Substitute, TwoDollarsAreOne) {
  EXPECT_EQ(replaced("$${HOSTNAME}"), "${HOSTNAME}");
  EXPECT_EQ(replaced("$$"), "$");
  EXPECT_EQ(replaced("$$$${"), "$${");
}

TEST(Substitute, ReplacesOnlyOnce) { EXPECT_EQ(replaced("${NESTED}"), "${HOSTNAME}"); }

TEST(Substitute, RefusesWhatItCannotReplace) {
  EXPECT_EQ(replaced("${ROBOT}"),
            "refused: names the environment variable ROBOT, which is not set");
  EXPECT_EQ(replaced("${}"), "refused: names the environment variable , which is not set");
  EXPECT_EQ(replaced("x${HOSTNAME"), "refused: has ${ without }; write $$ for a dollar sign");
}

TEST(Unknown, TablesAreThoseOfOptions) {
  EXPECT_TRUE(is_table("tcp"));
  EXPECT_FALSE(is_table("link"));
  EXPECT_FALSE(is_table("tcp.listen"));
}

TEST(Unknown, TheNearestKeyOrTheSameNameElsewhereIsSuggested) {
  EXPECT_EQ(unknown_key("tcp.listn"), "unknown key tcp.listn; did you mean tcp.listen?");
  EXPECT_EQ(unknown_key("links"), "unknown key links; did you mean link?");
  EXPECT_EQ(unknown_key("router.faults"), "unknown key router.faults; did you mean sim.faults?");
  EXPECT_EQ(unknown_key("tcp.flux"), "unknown key tcp.flux");
}

TEST(Unknown, TablesAreShownWithTheBracketsOfWhatIsMeant) {
  EXPECT_EQ(unknown_table("tpc", true), "unknown table [[tpc]]; did you mean [tcp]?");
  EXPECT_EQ(unknown_table("links", false), "unknown table [links]; did you mean [[link]]?");
  EXPECT_TRUE(
      unknown_table("flux", true).starts_with("unknown table [[flux]]; known are router, "));
}

TEST(Unknown, AmongEquallyNearTablesTheOneOfTheSameFormIsMeant) {
  EXPECT_EQ(unknown_table("routes", true), "unknown table [[routes]]; did you mean [[route]]?");
  EXPECT_EQ(unknown_table("routes", false), "unknown table [routes]; did you mean [router]?");
}

TEST(Unknown, KeysOfItemsAreTheItemsOnly) {
  const List& link = *find_list("link");
  EXPECT_EQ(unknown_item_key(link, "too"), "unknown key link.too; did you mean link.to?");
  EXPECT_EQ(unknown_item_key(*find_list("route"), "listen"),
            "unknown key route.listen; known are match, via");
}

TEST(PrintConfig, NamesTheOriginOfEveryValue) {
  const Loaded loaded =
      load({{{"r.toml", "[tcp]\n\nqueue = 1048576\n"}}, {"log.level=debug"}, kHost});
  const std::string text = print_config(loaded.config, loaded.origins);
  EXPECT_THAT(text,
              testing::StartsWith("[router]\nname = \"robot1\"                     # default\n"));
  EXPECT_THAT(text, testing::HasSubstr("queue = \"1MiB\"                      # r.toml:3\n"));
  EXPECT_THAT(text, testing::HasSubstr("[log]\nlevel = \"debug\"                     # --set 1\n"));
}

TEST(PrintConfig, PrintsEveryLinkAndRoute) {
  const Loaded loaded =
      load({{{"r.toml", "[[link]]\nkind = \"sub\"\n\n[[route]]\nmatch = \"*\"\nvia = \"r\"\n"}},
            {"link=kind=super,to=127.0.0.1"},
            kHost});
  EXPECT_THAT(print_config(loaded.config, loaded.origins), testing::EndsWith(R"(
[[link]]                            # r.toml:1
kind = "sub"                        # r.toml:2
system = "*"                        # default
paths = ["udp"]                     # default
name = ""                           # default
mailboxes = 65536                   # default
interval = "300ms"                  # default
rate = "0B"                         # default
reserve = 10                        # default
lifetime = "30s"                    # default
compress = "auto"                   # default
compress_own = false                # default

[[link]]                            # --set 1
kind = "super"                      # --set 1
to = "127.0.0.1:2010"               # --set 1
paths = ["udp"]                     # default
name = ""                           # default
mailboxes = 65536                   # default
interval = "300ms"                  # default
rate = "0B"                         # default
reserve = 10                        # default
lifetime = "30s"                    # default
compress = "auto"                   # default
compress_own = false                # default

[[route]]                           # r.toml:4
match = "*"                         # r.toml:5
via = "r"                           # r.toml:6
)"));
}

TEST(PrintConfig, LoadsBackToTheSameConfig) {
  const Loaded loaded = load(
      {{},
       {R"(router.name=a "b" \c ${HOSTNAME} $$ #d)", "tcp.listen=off", "message.max=262144B",
        "lifesign.interval=1500ms", "http.listen=[::1]:0", "security.insecure=true",
        "router.role=system", "router.system=3", "address.widths=6/8/10/8", "sim.faults=true",
        "message.classes=32/64/96/128/160/192/224",
        "link=kind=super,to=[fe80::1%eth0],rate=6MB,name=a $ \"b\"",
        "link=kind=super,to=robot2:1,interval=50ms,lifetime=100ms", "link=kind=peer,to=[::1]:2",
        "link=kind=peer,system=4", "link=kind=sub,rate=10001,reserve=0", "link=kind=sub,system=0",
        "route=match=Ladar(3/*),via=$HOME", "route=match=0x0C140000,via=b"},
       kHost});
  ASSERT_TRUE(loaded.ok()) << loaded.problems.front().to_string();
  const std::string text = print_config(loaded.config, loaded.origins);
  const Loaded again = load({{{"printed.toml", text}}, {}, kHost});
  EXPECT_TRUE(again.ok()) << text;
  EXPECT_EQ(again.config, loaded.config) << text;
}

Config with(std::vector<std::string> settings) {
  return load({{}, std::move(settings), kHost}).config;
}

TEST(Load, AListOfTextsIsATextOrAnArray) {
  const auto names = [](const std::string& text) { return load_text(text).config.http.names; };
  EXPECT_EQ(names("[http]\nnames = \"a.local, b\"\n"), "a.local, b");
  EXPECT_EQ(names("[http]\nnames = [\"a.local\", \"b\"]\n"), "a.local, b");
  EXPECT_EQ(names("[http]\nnames = []\n"), "");
  EXPECT_FALSE(load_text("[router]\nname = [\"a\"]\n").ok());
}

TEST(Reload, NothingChangedIsAnEmptyList) {
  EXPECT_TRUE(changes(defaults(kHost), defaults(kHost)).empty());
}

TEST(Reload, ChangesAreNamedInTheOrderOfTheTable) {
  std::vector<std::string> texts;
  for (const Change& change :
       changes(defaults(kHost), with({"log.level=debug", "router.id=2", "tcp.listen=off"})))
    texts.push_back(change.to_string());
  EXPECT_THAT(texts,
              testing::ElementsAre("router.id: 1 -> 2, needs a restart",
                                   "tcp.listen: \"127.0.0.1:2000\" -> \"off\", needs a restart",
                                   "log.level: \"info\" -> \"debug\""));
}

TEST(Reload, OnlyReloadableValuesAreTaken) {
  const Config running = defaults(kHost);
  const Config wanted = with({"log.level=debug", "router.id=2", "tcp.queue=1MiB"});
  const Config now = reloaded(running, wanted);
  EXPECT_EQ(now.log.level, LogLevel::kDebug);
  EXPECT_EQ(now.tcp.queue_bytes, 1U << 20);
  EXPECT_EQ(now.router.id, 1);
  for (const Change& change : changes(now, wanted)) EXPECT_FALSE(change.reloadable) << change.key;
}

std::vector<std::string> texts(const Config& before, const Config& after) {
  std::vector<std::string> list;
  for (const Change& change : changes(before, after)) list.push_back(change.to_string());
  return list;
}

TEST(Reload, LinksComeAndGoWithoutARestart) {
  const Config before = with({"security.insecure=true", "link=kind=super,to=10.9.1.1",
                              "link=kind=sub,system=1", "route=match=Ladar(3/*),via=a"});
  const Config after = with({"security.insecure=true", "link=kind=sub,system=1,rate=6MB",
                             "link=kind=peer,to=robot2", "route=match=Ladar(3/*),via=b"});
  ASSERT_EQ(before.links.size() + after.links.size(), 4U);
  EXPECT_THAT(texts(before, after),
              testing::ElementsAre("link \"sub of system 1\" rate: \"0B\" -> \"6MB\"",
                                   "link \"robot2:2010\": added", "link \"10.9.1.1:2010\": removed",
                                   "route \"Ladar(3/*)\" via: \"a\" -> \"b\""));
  EXPECT_EQ(reloaded(before, after), after);
  for (const Change& change : changes(before, after)) EXPECT_TRUE(change.reloadable);
}

TEST(Reload, TheOrderOfLinksIsAChange) {
  const std::string one = "link=kind=super,to=127.0.0.1:1";
  const std::string two = "link=kind=super,to=127.0.0.1:2";
  EXPECT_THAT(texts(with({one, two}), with({two, one})),
              testing::ElementsAre("link: in another order"));
  EXPECT_EQ(reloaded(with({one, two}), with({two, one})), with({two, one}));
}

TEST(Reload, EveryChangeOfALinkIsReported) {
  const Config before = with({"link=kind=super,to=127.0.0.1"});
  for (const char* key :
       {"name=a", "mailboxes=9", "interval=1s", "rate=1MB", "reserve=0", "lifetime=1s"}) {
    const Config after = with({std::string("link=kind=super,to=127.0.0.1,") + key});
    EXPECT_EQ(changes(before, after).size(), 1U) << key;
    EXPECT_EQ(reloaded(before, after), after) << key;
  }
  EXPECT_EQ(changes(before, with({"link=kind=peer,to=127.0.0.1"})).size(), 1U);
}

TEST(Reload, LinksWaitForWhatTheyWereCheckedAgainst) {
  const Config running = with({"router.role=subsystem", "link=kind=super,to=127.0.0.1"});
  const Config wanted = with({"router.role=system", "link=kind=sub", "log.level=debug"});
  const Config now = reloaded(running, wanted);
  EXPECT_EQ(now.links, running.links);
  EXPECT_EQ(now.log.level, LogLevel::kDebug);
  EXPECT_THAT(texts(now, wanted),
              testing::ElementsAre("router.role: \"subsystem\" -> \"system\", needs a restart",
                                   "link \"sub of *\": added, needs a restart",
                                   "link \"127.0.0.1:2010\": removed, needs a restart"));
}

}  // namespace load_test

}  // namespace tims::config
