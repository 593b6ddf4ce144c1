// The contract of all transports: bytes arrive complete and in order with plausible times; sent
// data arrives at the peer; the loss of a device is reported with a reason.
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/text.h"
#include "os/clock.h"
#include "os/file.h"
#include "rack/devices/transport.h"
#include "tests/support/eventually.h"
#include "tests/support/patience.h"
#include "tests/support/receive_until.h"
#include "tests/support/two_networks.h"

namespace rack::device {
namespace transport_contract_test {

using namespace std::chrono_literals;
using tims::os::File;

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::string text_of(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) text += static_cast<char>(byte);
  return text;
}

// The other end of the transport, controlled by the test.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::string address() = 0;
  // Called after the transport was opened.
  virtual void meet(Transport& /*transport*/) {}
  virtual void write(std::string_view text) = 0;
  virtual std::string read(std::size_t size) = 0;
  virtual void leave() = 0;
};

std::string read_from(int file, std::size_t size) {
  std::string text;
  const Time end = tims::os::now() + 5s;
  while (text.size() < size && tims::os::now() < end) {
    pollfd wait{.fd = file, .events = POLLIN, .revents = 0};
    if (::poll(&wait, 1, 100) <= 0) continue;
    std::array<char, 4096> buffer{};
    const ssize_t got = ::read(file, buffer.data(), buffer.size());
    if (got <= 0) break;
    text.append(buffer.data(), static_cast<std::size_t>(got));
  }
  return text;
}

// Master of a pseudo terminal whose slave is the serial line.
class SerialPeer final : public Peer {
 public:
  SerialPeer() : file_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    ::grantpt(file_.get());
    ::unlockpt(file_.get());
  }
  std::string address() override {
    std::array<char, 64> name{};
    ::ptsname_r(file_.get(), name.data(), name.size());
    return "serial:" + std::string(name.data()) + "?baud=500000";
  }
  void write(std::string_view text) override {
    ASSERT_EQ(::write(file_.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  std::string read(std::size_t size) override { return read_from(file_.get(), size); }
  void leave() override { file_.reset(); }

 private:
  File file_;
};

// Opens the terminal that the transport has made.
class PtyPeer final : public Peer {
 public:
  std::string address() override { return "pty:" + path_; }
  void meet(Transport&) override {
    file_ = File(::open(path_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    ASSERT_TRUE(file_);
  }
  void write(std::string_view text) override {
    ASSERT_EQ(::write(file_.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  std::string read(std::size_t size) override { return read_from(file_.get(), size); }
  void leave() override { file_.reset(); }

 private:
  const std::string path_ = testing::TempDir() + "device_pty_" + std::to_string(::getpid());
  File file_;
};

class TcpPeer final : public Peer {
 public:
  TcpPeer() : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(listener_.get(), reinterpret_cast<sockaddr*>(&any), sizeof any), 0);
    EXPECT_EQ(::listen(listener_.get(), 1), 0);
  }
  std::string address() override {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    ::getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&own), &size);
    return "tcp:127.0.0.1:" + std::to_string(ntohs(own.sin_port));
  }
  void meet(Transport&) override { file_ = File(::accept(listener_.get(), nullptr, nullptr)); }
  void write(std::string_view text) override {
    ASSERT_EQ(::write(file_.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  std::string read(std::size_t size) override { return read_from(file_.get(), size); }
  void leave() override { file_.reset(); }

 private:
  File listener_;
  File file_;
};

template <class OtherEnd>
class StreamContract : public testing::Test {
 public:
  void SetUp() override {
    const auto address = DeviceAddress::parse(peer_.address());
    ASSERT_TRUE(address) << address.error().message();
    auto opened = open_transport(*address, 115200);
    ASSERT_TRUE(opened) << opened.error().message();
    transport_ = std::move(*opened);
    peer_.meet(*transport_);
  }

 protected:
  OtherEnd peer_;
  std::unique_ptr<Transport> transport_;
  std::vector<Arrival> arrivals_;
  std::string text_;
};

using Streams = testing::Types<SerialPeer, PtyPeer, TcpPeer>;
TYPED_TEST_SUITE(StreamContract, Streams);

TYPED_TEST(StreamContract, EveryByteArrivesAsItIsWithItsTime) {
  std::string all;
  for (int i = 0; i < 256; ++i) all += static_cast<char>(i);
  const Time before = tims::os::now();
  this->peer_.write(all);
  ASSERT_TRUE(receive_until(*this->transport_, this->arrivals_, this->text_,
                            [&] { return this->text_.size() == all.size(); }));
  EXPECT_EQ(this->text_, all);
  for (const Arrival& arrival : this->arrivals_) {
    EXPECT_LE(arrival.first, arrival.last);
    EXPECT_GE(arrival.last, before);
    EXPECT_LE(arrival.last, tims::os::now());
  }
}

TYPED_TEST(StreamContract, WhatIsSentArrivesThere) {
  std::string all;
  for (int i = 0; i < 256; ++i) all += static_cast<char>(i);
  const auto sent = this->transport_->send(tims::os::now(), bytes_of(all), 0);
  ASSERT_TRUE(sent);
  EXPECT_TRUE(*sent);
  EXPECT_EQ(this->peer_.read(all.size()), all);
}

TYPED_TEST(StreamContract, APeerThatDoesNotReadLosesWholePieces) {
  const std::string piece(1000, 'x');
  bool full = false;
  for (int i = 0; i < 20'000 && !full; ++i) {
    const auto sent = this->transport_->send(tims::os::now(), bytes_of(piece), 0);
    ASSERT_TRUE(sent);
    full = !*sent;
  }
  EXPECT_TRUE(full);
  EXPECT_NE(this->transport_->next_timeout(), tims::kNever);
}

using StreamsThatEnd = testing::Types<SerialPeer, TcpPeer>;
template <class OtherEnd>
class StreamThatEnds : public StreamContract<OtherEnd> {};
TYPED_TEST_SUITE(StreamThatEnds, StreamsThatEnd);

TYPED_TEST(StreamThatEnds, ADeviceThatIsGoneIsReported) {
  this->peer_.write("last bytes");
  ASSERT_TRUE(receive_until(*this->transport_, this->arrivals_, this->text_,
                            [&] { return this->text_.size() == 10; }));
  this->peer_.leave();
  const auto gone =
      receive_until(*this->transport_, this->arrivals_, this->text_, [] { return false; });
  ASSERT_FALSE(gone);
  EXPECT_THAT(gone.error().detail(),
              testing::AnyOf(testing::HasSubstr("gone"), testing::HasSubstr("closed")));
}

TEST(SerialTest, AnotherProgramOnTheLineIsRefusedByName) {
  SerialPeer peer;
  const auto address = DeviceAddress::parse(peer.address());
  const auto first = open_transport(*address, 9600);
  ASSERT_TRUE(first);
  const auto second = open_transport(*address, 9600);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().detail(),
              testing::HasSubstr("(pid " + std::to_string(::getpid()) + ")"));
}

TEST(SerialTest, AMissingDeviceIsNamedWithWhatToDo) {
  const auto opened = open_transport(*DeviceAddress::parse("serial:/dev/ttyNONE"), 9600);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().detail(), testing::HasSubstr("timsctl device list"));
}

TEST(TcpTest, ARefusedConnectionIsReported) {
  std::string address;
  {
    TcpPeer peer;
    address = peer.address();
  }
  const auto opened = open_transport(*DeviceAddress::parse(address), 0);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().detail(), testing::HasSubstr("refused"));
}

// The device was switched off without closing the connection.
TEST(TcpTest, ADeviceThatLostItsPowerIsNoticed) {
  const auto networks = tims::test::TwoNetworks::enter();
  if (!networks) GTEST_SKIP() << networks.error().message();
  const File listener = networks->on_the_right([] {
    File socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(2112);
    EXPECT_EQ(::bind(socket.get(), reinterpret_cast<sockaddr*>(&where), sizeof where), 0);
    EXPECT_EQ(::listen(socket.get(), 1), 0);
    return socket;
  });
  const auto address = DeviceAddress::parse("tcp:" + std::string(networks->kRight) + ":2112");
  // The first packets of a cable that was just plugged in may get lost.
  auto scanner = open_transport(*address, 0);
  ASSERT_TRUE(tims::test::eventually([&]() -> std::string {
    if (!scanner) scanner = open_transport(*address, 0);
    return scanner ? "" : scanner.error().message();
  }));
  const File peer(::accept(listener.get(), nullptr, nullptr));
  ASSERT_EQ(::write(peer.get(), "scan", 4), 4);
  std::vector<Arrival> arrivals;
  std::string text;
  ASSERT_TRUE(receive_until(**scanner, arrivals, text, [&] { return text == "scan"; }));
  networks->on_the_right([&] {
    ASSERT_TRUE(networks->run("ip address del " + std::string(networks->kRight) + "/24 dev cable"));
  });
  const Time off = tims::os::now();
  const auto received = receive_until(**scanner, arrivals, text, [] { return false; });
  ASSERT_FALSE(received) << "it is believed to be there for ever";
  EXPECT_THAT(received.error().detail(), testing::HasSubstr("the device is gone"));
  EXPECT_LE(tims::os::now() - off, tims::test::kSlowdown * 4s);
}

TEST(UdpTest, DatagramsStayWholeAndOnlyThoseOfThePeerAreReceived) {
  auto here = open_transport(*DeviceAddress::parse("udp:127.0.0.1:23680"), 0);
  ASSERT_TRUE(here) << here.error().message();
  const File device(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const File stranger(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in other{};
  other.sin_family = AF_INET;
  ASSERT_EQ(::inet_pton(AF_INET, "127.0.0.2", &other.sin_addr), 1);
  ASSERT_EQ(::bind(stranger.get(), reinterpret_cast<sockaddr*>(&other), sizeof other), 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(23680);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const auto send_text = [&](const File& from, std::string_view text) {
    ::sendto(from.get(), text.data(), text.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
  };
  send_text(stranger, "not wanted");
  send_text(device, "one");
  send_text(device, "");
  send_text(device, "two");
  std::vector<Arrival> arrivals;
  std::string text;
  ASSERT_TRUE(receive_until(**here, arrivals, text, [&] { return arrivals.size() == 3; }));
  EXPECT_EQ(text, "onetwo");
}

}  // namespace transport_contract_test
}  // namespace rack::device
