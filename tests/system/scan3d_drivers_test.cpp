// Drivers of scanners of space, real programs, with emulated scanners in the network.
#include <fstream>

#include <arpa/inet.h>
#include <sys/socket.h>

#include "os/file.h"
#include "rack/proxies/scan3d.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace {

using rack::Scan3dProxy;

constexpr std::uint32_t kScan3d = tims::class_id::kScan3d << 16;

// Nobody else has it at this moment.
std::string free_port(int kind) {
  const os::File socket(::socket(AF_INET, kind, 0));
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof any;
  EXPECT_EQ(::bind(socket.get(), reinterpret_cast<const sockaddr*>(&any), size), 0);
  EXPECT_EQ(::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&any), &size), 0);
  return std::to_string(ntohs(any.sin_port));
}

class Scan3dDriversTest : public ModulesTest {
 protected:
  Scan3dProxy scanner() { return proxy<Scan3dProxy>(kScan3d); }

  ChildProcess emulate(const std::string& name, const std::string& address) {
    auto child = ChildProcess::start({std::string(TIMS_PROGRAMS) + "/rack-emulate", name, address});
    EXPECT_TRUE(child) << child.error().message();
    const auto ready = child->wait_for_line("speaks with it");
    EXPECT_TRUE(ready) << ready.error().message();
    return std::move(*child);
  }

  TemporaryFolder folder_;
};

TEST_F(Scan3dDriversTest, AnOusterIsAskedWhatItIs) {
  const std::string data = free_port(SOCK_DGRAM);
  const std::string page = "127.0.0.1:" + free_port(SOCK_STREAM);
  const std::string kept = folder_.path() / "os.json";
  auto& program =
      start("Scan3dOuster", {"--device=udp::" + data, "--scanner=" + page, "--metadata=" + kept});
  EXPECT_FALSE(scanner().on());
  const auto said = program.wait_for_line("get_beam_intrinsics");
  EXPECT_TRUE(said) << said.error().message();

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

TEST_F(Scan3dDriversTest, WithoutWordOfTheOusterItSaysWhatIsMissing) {
  auto& program = start("Scan3dOuster");
  EXPECT_FALSE(scanner().on());
  const auto said = program.wait_for_line("scanner is missing");
  EXPECT_TRUE(said) << said.error().message();
}

}  // namespace
}  // namespace tims::test
