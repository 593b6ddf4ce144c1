#include "components/devices/io/device_users.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "os/file.h"
#include "tests/support/temporary_folder.h"

namespace rack::device {
namespace device_users_test {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

void process(const fs::path& proc, const std::string& pid, const std::string& command,
             const std::string& device, const std::vector<std::string>& descriptors) {
  fs::create_directories(proc / pid / "fd");
  std::ofstream(proc / pid / "comm") << command << '\n';
  for (const std::string& name : descriptors) fs::create_symlink(device, proc / pid / "fd" / name);
}

TEST(DeviceUsersTest, ProgramsThatUseADeviceAreNamedOnce) {
  const tims::test::TemporaryFolder proc;
  process(proc.path(), "4711", "LadarHokuyoUrg", "/dev/ttyACM0", {"3", "4"});
  process(proc.path(), "12", "bash", "/tmp/file", {"1"});
  process(proc.path(), "self", "none", "/dev/ttyACM0", {"1"});
  EXPECT_THAT(device_users(proc.path()),
              ElementsAre(Pair("/dev/ttyACM0", "LadarHokuyoUrg (pid 4711)")));
  EXPECT_THAT(device_users(proc.path() / "missing"), IsEmpty());
}

TEST(DeviceUsersTest, ThisProgramIsFound) {
  const tims::os::File file(::open("/dev/zero", O_RDONLY | O_CLOEXEC));
  ASSERT_TRUE(file);
  const auto users = device_users();
  bool is_found = false;
  for (auto [at, end] = users.equal_range("/dev/zero"); at != end; ++at)
    is_found = is_found || at->second.ends_with("(pid " + std::to_string(::getpid()) + ")");
  EXPECT_TRUE(is_found);
}

}  // namespace device_users_test
}  // namespace rack::device
