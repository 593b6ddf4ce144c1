#include "os/service_manager.h"

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "os/socket.h"

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

// What has been read from one end of a connection.
std::vector<std::string> received_from(const File& connection) {
  std::vector<std::string> all;
  std::array<char, 256> text{};
  ssize_t n = 0;
  while ((n = ::recv(connection.get(), text.data(), text.size(), MSG_DONTWAIT)) > 0)
    all.emplace_back(text.data(), static_cast<std::size_t>(n));
  return all;
}

TEST(ServiceManagerConnection, NothingThatWasReportedIsLostWithTheProgram) {
  constexpr std::size_t kReports = 50;  // five times the queue of a datagram socket
  auto pair = make_record_pair();
  ASSERT_TRUE(pair.ok());
  {
    ServiceManager manager(std::move(pair->one));
    EXPECT_TRUE(manager.listens());
    for (std::size_t i = 0; i < kReports; ++i)
      EXPECT_TRUE(manager.report("STATUS", std::to_string(i)));
  }
  const auto all = received_from(pair->other);
  ASSERT_EQ(all.size(), kReports);
  EXPECT_EQ(all.back(), "STATUS=49");
}

TEST(ServiceManagerConnection, WaitsForRoomAsLongAsItMay) {
  auto pair = make_record_pair();
  ASSERT_TRUE(pair.ok());
  ServiceManager manager(std::move(pair->one));
  ASSERT_LT(fill(manager), 100'000);
  EXPECT_FALSE(manager.report("STATUS", "off", std::chrono::milliseconds(2)));
  (void)received_from(pair->other);
  EXPECT_TRUE(manager.report("READY", "1", std::chrono::milliseconds(2)));
  EXPECT_THAT(received_from(pair->other), ElementsAre("READY=1", "STATUS=off", "WATCHDOG=1"));
  pair->other.reset();
  EXPECT_TRUE(manager.report("READY", "1")) << "nobody is left to wait for";
}

TEST(ServiceManagerConnection, OfTheEnvironment) {
  auto pair = make_record_pair();
  ASSERT_TRUE(pair.ok());
  const auto set = [](const std::string& text) {
    ::setenv(ServiceManager::kConnectionVariable, text.c_str(), 1);
  };
  const std::string text = ServiceManager::connection_text(pair->one.get());
  for (const std::string& wrong : {text + "1", std::string("-1"), std::string("x"),
                                   std::string("99999:1"), std::to_string(pair->one.get())}) {
    set(wrong);
    EXPECT_FALSE(ServiceManager::of_environment().listens()) << wrong;
  }
  set(text);
  ServiceManager manager = ServiceManager::of_environment();
  (void)pair->one.release();  // the manager has it now
  EXPECT_TRUE(manager.listens());
  EXPECT_FALSE(ServiceManager::of_environment().listens()) << "there is one in a program";
  manager.report("READY", "1");
  EXPECT_THAT(received_from(pair->other), ElementsAre("READY=1"));
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
