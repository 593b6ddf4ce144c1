#include "tools/timsctl/host.h"

#include <gtest/gtest.h>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/host_facts.h"

namespace timsctl {
namespace {

TEST(Host, EveryForm) {
  EXPECT_EQ(parse_host("robot"), Host(TcpHost{"robot", "2000"}));
  EXPECT_EQ(parse_host("robot:2001"), Host(TcpHost{"robot", "2001"}));
  EXPECT_EQ(parse_host("[::1]:2001"), Host(TcpHost{"::1", "2001"}));
  EXPECT_EQ(parse_host("[::1]"), Host(TcpHost{"::1", "2000"}));
  EXPECT_EQ(parse_host("::1"), Host(TcpHost{"::1", "2000"}));
  EXPECT_EQ(parse_host("unix:/run/x.sock"), Host(UnixHost{"/run/x.sock"}));
  EXPECT_EQ(parse_host("/run/x.sock"), Host(UnixHost{"/run/x.sock"}));
}

TEST(Host, OtherTextsAreRefused) {
  for (const char* bad :
       {"", ":2000", "robot:", "robot:0", "robot:70000", "robot:x", "[::1", "[::1]x"})
    EXPECT_THROW(parse_host(bad), Failure) << bad;
}

TEST(HostFacts, OfThisProcess) {
  const auto files = open_files(static_cast<std::uint32_t>(::getpid()));
  ASSERT_TRUE(files);
  EXPECT_GT(files->limit, 0U);
  EXPECT_GE(files->open.value_or(0), 3U);
  EXPECT_TRUE(is_running(static_cast<std::uint32_t>(::getpid())));
  EXPECT_FALSE(is_running(0x3FFFFFFF));
  EXPECT_TRUE(shared_memory().memfd);
  EXPECT_FALSE(socket_file("/no/such/file"));
}

}  // namespace
}  // namespace timsctl
