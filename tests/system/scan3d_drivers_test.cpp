// Drivers of 3D scanners as real programs, with emulated scanners in the network.
#include <fstream>

#include <sys/socket.h>

#include "rack/proxies/scan3d.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace scan3d_drivers_test {

using rack::Scan3dProxy;

constexpr std::uint32_t kScan3d = tims::class_id::kScan3d << 16;

class Scan3dDriversTest : public ModulesTest {
 protected:
  Scan3dProxy scanner() { return proxy<Scan3dProxy>(kScan3d); }

  TemporaryFolder folder_;
};

TEST_F(Scan3dDriversTest, ItRequestsTheMetadataOfAnOuster) {
  const std::string data = free_port(SOCK_DGRAM);
  const std::string page = "127.0.0.1:" + free_port(SOCK_STREAM);
  const std::string kept = folder_.path() / "os.json";
  auto& program =
      start("Scan3dOuster", {"--device=udp::" + data, "--scanner=" + page, "--metadata=" + kept});
  EXPECT_FALSE(scanner().on());
  const auto line = program.wait_for_line("get_beam_intrinsics");
  EXPECT_TRUE(line) << line.error().message();

  const auto its_page = emulate("ouster-page", "tcp:" + page);
  const auto its_data = emulate("ouster", "udp:127.0.0.1:" + data + "?local=0");
  ASSERT_TRUE(scanner().on());
  const auto scan = scanner().get_data();
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->pointNum, 1024 * 16);
  std::ifstream file(kept);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("beam_altitude_angles"), std::string::npos);
}

TEST_F(Scan3dDriversTest, WithoutMetadataOfTheOusterItReportsWhatIsMissing) {
  auto& program = start("Scan3dOuster");
  EXPECT_FALSE(scanner().on());
  const auto line = program.wait_for_line("scanner is missing");
  EXPECT_TRUE(line) << line.error().message();
}

}  // namespace scan3d_drivers_test
}  // namespace tims::test
