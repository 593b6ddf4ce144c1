#include "os/service_manager.h"

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace tims::os {

namespace service_manager_test {

using testing::ElementsAre;

// A service manager that reads when it is asked to.
class ServiceManagerTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ = "@tims-service-manager-test-" + std::to_string(::getpid());
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path + 1, path_.data() + 1, path_.size() - 1);
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path_.size());
    ASSERT_EQ(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
  }

  std::vector<std::string> received() const {
    std::vector<std::string> all;
    std::array<char, 256> text{};
    ssize_t n = 0;
    while ((n = ::recv(socket_.get(), text.data(), text.size(), MSG_DONTWAIT)) >= 0)
      all.emplace_back(text.data(), static_cast<std::size_t>(n));
    return all;
  }

  std::string path_;
  File socket_{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
};

// Reports until there is no room; returns how many were sent.
int fill(ServiceManager& manager) {
  int sent = 0;
  while (sent < 100'000 && manager.report("WATCHDOG", "1")) ++sent;
  return sent;
}

TEST_F(ServiceManagerTest, ReceivesAReportAtOnce) {
  ServiceManager manager(path_);
  EXPECT_TRUE(manager.report("READY", "1\nX_TIMS_ADDRESS=0x01110000"));
  EXPECT_THAT(received(), ElementsAre("READY=1\nX_TIMS_ADDRESS=0x01110000"));
}

TEST_F(ServiceManagerTest, ReceivesTheNewestValuesWhenItReadsAgain) {
  ServiceManager others(path_);
  const auto full = static_cast<std::size_t>(fill(others));
  ASSERT_LT(full, 100'000U);
  ServiceManager manager(path_);
  EXPECT_FALSE(manager.report("READY", "1"));
  EXPECT_FALSE(manager.report("STATUS", "off"));
  EXPECT_FALSE(manager.report("STATUS", "on"));
  EXPECT_FALSE(manager.flush());
  EXPECT_EQ(received().size(), full);
  EXPECT_TRUE(manager.flush());
  EXPECT_THAT(received(), ElementsAre("READY=1", "STATUS=on"));
  EXPECT_TRUE(manager.flush());
  EXPECT_THAT(received(), ElementsAre());
}

TEST_F(ServiceManagerTest, NothingIsKeptForOneThatHasGone) {
  ServiceManager manager(path_);
  socket_.reset();
  EXPECT_TRUE(manager.report("READY", "1"));
}

TEST(ServiceManager, WithoutOneReportsAreDiscarded) {
  for (const std::string& path : {std::string(), std::string(200, 'x')}) {
    ServiceManager manager(path);
    EXPECT_FALSE(manager.listens());
    EXPECT_TRUE(manager.report("READY", "1"));
    EXPECT_TRUE(manager.flush());
  }
}

}  // namespace service_manager_test
}  // namespace tims::os
