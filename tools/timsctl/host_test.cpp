#include "tools/timsctl/host.h"

#include <gtest/gtest.h>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/host_facts.h"

namespace timsctl {
namespace {

TEST(Host, AsAnEndpointIsWritten) {
  EXPECT_EQ(parse_host("robot:2001"), Host(TcpHost{"robot", 2001}));
  EXPECT_EQ(parse_host("/run/x.sock"), Host(UnixHost{"/run/x.sock"}));
  EXPECT_THROW(parse_host("robot:0"), Failure);
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
