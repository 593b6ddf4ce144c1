// The end of a stream: each listener of a component that is turned off gets ERROR, on a busy
// machine too, whenever it subscribes and whether or not the component is turned on again at once.
#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rack/proxies/chassis.h"
#include "tests/support/eventually.h"
#include "tests/support/tcp_client.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace stream_end_test {

using namespace std::chrono_literals;

constexpr std::uint32_t kChassis = 0x00110000;
constexpr int kOffs = 1000;

// Uses the processors besides the test.
class BusyMachine {
 public:
  BusyMachine() {
    for (unsigned i = 0; i < std::max(2U, std::thread::hardware_concurrency()); ++i)
      threads_.emplace_back([this] {
        while (!ends_.load(std::memory_order_relaxed)) {
        }
      });
  }
  ~BusyMachine() {
    ends_.store(true);
    for (std::thread& thread : threads_) thread.join();
  }
  BusyMachine(const BusyMachine&) = delete;
  BusyMachine& operator=(const BusyMachine&) = delete;

 private:
  std::atomic<bool> ends_ = false;
  std::vector<std::thread> threads_;
};

// A listener over TCP, as the graphical interface of the original.
class RemoteListener {
 public:
  RemoteListener(const std::string& router, Address data) : data_(data) {
    auto client = TcpClient::connect(router);
    EXPECT_TRUE(client.ok());
    if (client) client_.emplace(std::move(*client));
    EXPECT_TRUE(client_ && client_->register_mailbox(data));
  }
  bool subscribe() {
    const std::array<std::uint32_t, 2> body{0, data_.raw()};
    if (!client_->send({.type = type::kGetContData, .dest = Address(kChassis), .src = data_},
                       std::as_bytes(std::span(body))))
      return false;
    return next(type::kContData) == type::kContData;
  }
  bool ends() { return next(type::kError) == type::kError; }

 private:
  // The next message of this type or ERROR.
  std::int8_t next(std::int8_t wanted) {
    for (;;) {
      const auto message = client_->receive();
      if (!message) return type::kTimeout;
      const std::int8_t type = message->header.type;
      if (type == wanted || type == type::kError) return type;
    }
  }

  Address data_;
  std::optional<TcpClient> client_;
};

class StreamEndTest : public ModulesTest {
 protected:
  void SetUp() override {
    ModulesTest::SetUp();
    start("ChassisSim", {"--periodTime=1"});
  }
  static bool ends(Mailbox& data) {
    const Time end = os::deadline_after(kPatience);
    while (os::now() < end) {
      const auto message = data.peek_for(end - os::now());
      if (message && message->header().type == type::kError) return true;
    }
    return false;
  }
};

TEST_F(StreamEndTest, AThousandOffsReachAllListeners) {
  auto chassis = proxy<rack::ChassisProxy>(kChassis);
  std::vector<Mailbox> listeners;
  for (std::uint32_t i = 0; i < 3; ++i)
    listeners.push_back(open(*session_, 0x00180000U + i, {.slots = 2, .body_max = 64}));
  RemoteListener remote(router_.tcp(), Address(0x00190000));
  const BusyMachine busy;
  for (int i = 0; i < kOffs; ++i) {
    ASSERT_TRUE(chassis.on()) << i;
    for (Mailbox& listener : listeners) {
      listener.clean();
      ASSERT_TRUE(chassis.get_cont_data(0, listener.address())) << i;
    }
    ASSERT_TRUE(remote.subscribe()) << i;
    ASSERT_TRUE(chassis.off()) << i;
    const bool on_at_once = i % 2 == 0;
    ASSERT_TRUE(!on_at_once || chassis.on()) << i;
    for (Mailbox& listener : listeners) ASSERT_TRUE(ends(listener)) << i;
    ASSERT_TRUE(remote.ends()) << i;
  }
}

// It subscribes at any moment, also between the OFF and the end of the streams.
TEST_F(StreamEndTest, NobodySubscribesToAStreamThatHasEnded) {
  auto chassis = proxy<rack::ChassisProxy>(kChassis);
  std::atomic<bool> ready = false;
  std::atomic<bool> goes_on = true;
  std::atomic<int> ended = 0;
  std::thread subscriber([&] {
    auto session = this->session();
    Mailbox work = open(session, 0x001A0001);
    Mailbox data = open(session, 0x001A0002, {.slots = 2, .body_max = 64});
    rack::ChassisProxy producer(work, Address(kChassis), {.data = kPatience});
    ready = true;
    while (goes_on) {
      data.clean();
      if (!producer.get_cont_data(0, data.address())) continue;
      if (!ends(data)) break;
      ++ended;
    }
    ready = false;
  });
  const BusyMachine busy;
  EXPECT_TRUE(eventually([&] { return ready.load(); }, "the subscriber begins"));
  for (int i = 0; i < kOffs && ready; ++i) {
    EXPECT_TRUE(chassis.on()) << i;
    std::this_thread::yield();
    EXPECT_TRUE(chassis.off()) << i;
  }
  EXPECT_TRUE(ready) << "it has missed the end of a stream after " << ended;
  goes_on = false;
  (void)chassis.on();
  (void)chassis.off();
  subscriber.join();
  EXPECT_GT(ended, 0);
}

}  // namespace stream_end_test
}  // namespace tims::test
