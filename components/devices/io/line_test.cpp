// The device end of a line: it has the real rate, and bytes sent at a different rate are garbled.
#include "components/devices/io/line.h"

#include <array>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include "os/clock.h"
#include "rack/devices/device_clock.h"
#include "tests/support/temporary_folder.h"

namespace rack::device {
namespace line_test {

using namespace std::chrono_literals;

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::unique_ptr<Transport> opened(const std::string& text, std::uint32_t baud,
                                  bool from_the_device = false) {
  const auto address = DeviceAddress::parse(text);
  EXPECT_TRUE(address) << text;
  auto opened = from_the_device ? open_line(*address, baud) : open_transport(*address, baud);
  EXPECT_TRUE(opened) << opened.error().message();
  return opened ? std::move(*opened) : nullptr;
}

// Runs both transports until `to` has received `size` bytes.
std::string exchange(Transport& from, Transport& to, std::size_t size, Duration limit = 20s) {
  std::string received;
  const Time end = tims::os::now() + limit;
  while (received.size() < size && tims::os::now() < end) {
    std::array<pollfd, 2> wait = {pollfd{.fd = from.descriptor(), .events = POLLIN, .revents = 0},
                                  pollfd{.fd = to.descriptor(), .events = POLLIN, .revents = 0}};
    ::poll(wait.data(), wait.size(), 1);
    EXPECT_TRUE(from.receive(tims::os::now(), [](const Arrival&) {}));
    EXPECT_TRUE(to.receive(tims::os::now(), [&](const Arrival& arrival) {
      for (const std::byte byte : arrival.bytes) received += static_cast<char>(byte);
    }));
  }
  return received;
}

class LineTest : public testing::Test {
 protected:
  LineTest() : device_(opened("pty:" + path_, 9600, true)) {}

  tims::test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() / "line";
  std::unique_ptr<Transport> device_;
};

TEST_F(LineTest, BothUnderstandEachOtherAtOneRate) {
  const auto driver = opened("serial:" + path_, 9600);
  ASSERT_TRUE(*driver->send(tims::os::now(), bytes_of("question"), 0));
  EXPECT_EQ(exchange(*driver, *device_, 8), "question");
  ASSERT_TRUE(*device_->send(tims::os::now(), bytes_of("answer"), 0));
  EXPECT_EQ(exchange(*device_, *driver, 6), "answer");
}

// 960 bytes at 9600 baud take 1 s. The test host may be slow, but the line must never be fast.
TEST_F(LineTest, BytesComeNoFasterThanTheLineCarriesThem) {
  const auto driver = opened("serial:" + path_, 9600);
  const std::string text(480, 'x');
  const Time begin = tims::os::now();
  ASSERT_TRUE(*device_->send(begin, bytes_of(text), 0));
  EXPECT_EQ(exchange(*device_, *driver, text.size()), text);
  const Duration took = tims::os::now() - begin;
  EXPECT_GE(took, 490ms) << "without the last slice";
  EXPECT_LE(took, 10s);
}

TEST_F(LineTest, AnotherRateIsNoiseInBothDirections) {
  const auto driver = opened("serial:" + path_, 115200);
  ASSERT_TRUE(*driver->send(tims::os::now(), bytes_of("question"), 0));
  EXPECT_NE(exchange(*driver, *device_, 8), "question");
  ASSERT_TRUE(*device_->send(tims::os::now(), bytes_of("answer"), 0));
  EXPECT_NE(exchange(*device_, *driver, 6), "answer");
  driver->set_baud(9600);
  ASSERT_TRUE(*driver->send(tims::os::now(), bytes_of("question"), 0));
  EXPECT_EQ(exchange(*driver, *device_, 8), "question");
}

TEST_F(LineTest, ADeviceWithoutARateIsUnderstoodAtAny) {
  device_.reset();  // closing the device removes its link
  device_ = opened("pty:" + path_, 0, true);
  const auto driver = opened("serial:" + path_, 57600);
  ASSERT_TRUE(*driver->send(tims::os::now(), bytes_of("question"), 0));
  EXPECT_EQ(exchange(*driver, *device_, 8), "question");
  ASSERT_TRUE(*device_->send(tims::os::now(), bytes_of("answer"), 0));
  EXPECT_EQ(exchange(*device_, *driver, 6), "answer");
}

TEST_F(LineTest, ADeviceChangesItsRateBehindItsAnswer) {
  const auto driver = opened("serial:" + path_, 9600);
  ASSERT_TRUE(*device_->send(tims::os::now(), bytes_of("I change"), 0));
  device_->set_baud(115200);
  EXPECT_EQ(exchange(*device_, *driver, 8), "I change");
  driver->set_baud(115200);
  ASSERT_TRUE(*device_->send(tims::os::now(), bytes_of("changed"), 0));
  EXPECT_EQ(exchange(*device_, *driver, 7), "changed");
}

TEST_F(LineTest, NothingComesBackBeforeThereIsADriver) {
  ASSERT_TRUE(*device_->send(tims::os::now(), bytes_of("to nobody\n"), 0));
  const auto nobody = opened("tcp:127.0.0.1:23122", 0, true);
  EXPECT_EQ(exchange(*nobody, *device_, 1, 100ms), "");
}

TEST_F(LineTest, DriversComeAndGo) {
  for (int i = 0; i < 3; ++i) {
    const auto driver = opened("serial:" + path_, 9600);
    ASSERT_TRUE(*driver->send(tims::os::now(), bytes_of("hello"), 0));
    EXPECT_EQ(exchange(*driver, *device_, 5), "hello");
  }
}

// Motors behind an SLCAN adapter: both sides send and receive frames.
TEST_F(LineTest, ABusBehindATextLineCarriesFrames) {
  device_.reset();
  device_ = opened("pty:" + path_ + "?can=500000", 0, true);
  const auto driver = opened("serial:" + path_ + "?can=500000", 115200);
  const auto expect_received = [](Transport& from, Transport& to, std::uint32_t id,
                                  std::string_view text) {
    EXPECT_TRUE(*from.send(tims::os::now(), bytes_of(text), id));
    std::uint32_t come = 0;
    std::string bytes;
    for (const Time end = tims::os::now() + 20s; come == 0 && tims::os::now() < end;) {
      pollfd wait{.fd = to.descriptor(), .events = POLLIN, .revents = 0};
      ::poll(&wait, 1, 1);
      EXPECT_TRUE(to.receive(tims::os::now(), [&](const Arrival& frame) {
        come = frame.id;
        for (const std::byte byte : frame.bytes) bytes += static_cast<char>(byte);
      }));
    }
    EXPECT_EQ(come, id);
    EXPECT_EQ(bytes, text);
  };
  expect_received(*driver, *device_, 0x201, "driving");
  expect_received(*device_, *driver, 0x181, "turned");
}

TEST_F(LineTest, ItsNameGoesWithIt) {
  device_.reset();
  EXPECT_NE(::access(path_.c_str(), F_OK), 0);
}

TEST(LinePortTest, TheNewestClientHasTheDevice) {
  const auto device = opened("tcp:127.0.0.1:23121", 0, true);
  ASSERT_TRUE(device);
  EXPECT_FALSE(*device->send(tims::os::now(), {}, 0)) << "nobody is there";
  auto first = opened("tcp:127.0.0.1:23121", 0);
  ASSERT_TRUE(*first->send(tims::os::now(), bytes_of("one"), 0));
  EXPECT_EQ(exchange(*first, *device, 3), "one");
  EXPECT_TRUE(*device->send(tims::os::now(), {}, 0));
  const auto second = opened("tcp:127.0.0.1:23121", 0);
  ASSERT_TRUE(*second->send(tims::os::now(), bytes_of("two"), 0));
  EXPECT_EQ(exchange(*second, *device, 3), "two");
  ASSERT_TRUE(*device->send(tims::os::now(), bytes_of("answer"), 0));
  EXPECT_EQ(exchange(*device, *second, 6), "answer");
}

// Its events in order: "+" a client has come or gone, and what was received.
std::string events_of(Transport& device, std::string_view wanted) {
  std::string events;
  for (const Time end = tims::os::now() + 20s; events != wanted && tims::os::now() < end;) {
    pollfd wait{.fd = device.descriptor(), .events = POLLIN, .revents = 0};
    ::poll(&wait, 1, 1);
    EXPECT_TRUE(device.receive(tims::os::now(), [&](const Arrival& arrival) {
      if (arrival.is_restart) events += '+';
      for (const std::byte byte : arrival.bytes) events += static_cast<char>(byte);
    }));
  }
  return events;
}

TEST(LinePortTest, TheDeviceStartsAgainWithEachClient) {
  const auto device = opened("tcp:127.0.0.1:23123", 0, true);
  auto first = opened("tcp:127.0.0.1:23123", 0);
  ASSERT_TRUE(*first->send(tims::os::now(), bytes_of("one"), 0));
  EXPECT_EQ(events_of(*device, "+one"), "+one");
  auto second = opened("tcp:127.0.0.1:23123", 0);
  ASSERT_TRUE(*second->send(tims::os::now(), bytes_of("two"), 0));
  EXPECT_EQ(events_of(*device, "+two"), "+two");
  second.reset();
  EXPECT_EQ(events_of(*device, "+"), "+") << "it has gone";
  EXPECT_FALSE(*device->send(tims::os::now(), bytes_of("to nobody"), 0));
}

// A client that does not read gets pictures until its buffers are full, and later whole ones again.
TEST(LinePortTest, ASlowClientMissesWholePieces) {
  const auto device = opened("tcp:127.0.0.1:23124", 0, true);
  const auto client = opened("tcp:127.0.0.1:23124", 0);
  ASSERT_TRUE(*client->send(tims::os::now(), bytes_of("x"), 0));
  EXPECT_EQ(events_of(*device, "+x"), "+x");
  const std::string picture(300000, 'p');
  std::size_t taken = 0;
  std::size_t refused = 0;
  for (int i = 0; i < 200; ++i) {
    const bool is_taken = *device->send(tims::os::now(), bytes_of(picture), 0);
    is_taken ? ++taken : ++refused;
  }
  EXPECT_GT(taken, 0U) << "larger than what may wait, but nothing else waited";
  EXPECT_GT(refused, 100U);
  EXPECT_EQ(exchange(*device, *client, taken * picture.size()).size(), taken * picture.size());
  EXPECT_TRUE(*device->send(tims::os::now(), bytes_of(picture), 0));
}

TEST(PaceTest, BytesComeAsALineCarriesThem) {
  constexpr std::uint32_t kBaud = 115200;
  constexpr std::size_t kBytes = 1000;
  Pace pace;
  const Time begin{1000s};
  for (const Time start : {begin, begin + 1s}) {  // an idle line has nothing saved up
    EXPECT_EQ(pace.allowed(start, kBytes, kBaud), 0U) << "none before it was on the line";
    Time now = start;
    std::size_t calls = 0;
    for (std::size_t sent = 0; sent < kBytes; ++calls) {
      ASSERT_GT(pace.next(), now) << "otherwise a caller that waits for it would not sleep";
      now = pace.next();
      sent += pace.allowed(now, kBytes - sent, kBaud);
      EXPECT_LE(line_time(sent, kBaud), now - start + 1us);
    }
    EXPECT_LE(now - start, line_time(kBytes, kBaud) + 1us) << "and not later";
    EXPECT_GE(now - start + 1us, line_time(kBytes, kBaud));
    EXPECT_NEAR(static_cast<double>(calls), 91, 2) << "a call a millisecond";
  }
  EXPECT_EQ(pace.allowed(begin + 3s, 77, 0), 77U) << "no rate, no pace";
}

TEST(PaceTest, SlowLinesAreWaitedForByteByByte) {
  Pace pace;
  const Time begin{1000s};
  EXPECT_EQ(pace.allowed(begin, 2, 1200), 0U);
  EXPECT_EQ(pace.next(), begin + line_time(1, 1200));
  EXPECT_EQ(pace.allowed(pace.next(), 2, 1200), 1U);
  EXPECT_EQ(pace.allowed(pace.next(), 1, 1200), 1U);
}

}  // namespace line_test
}  // namespace rack::device
