#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/load.h"

namespace tims::config {
namespace {

const Host kHost{.name = "robot1", .uid = 0, .environment = {}};

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

}  // namespace
}  // namespace tims::config
