// What arrives from another router over TCP goes to clients of the TCP port without a copy, however
// the bytes are cut on their way.
#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/socket.h"
#include "router/core/router_fixture.h"
#include "router/io/tcp_path_fixture.h"
#include "router/io/tcp_port.h"
#include "router/link/links.h"
#include "tests/support/tcp_client.h"
#include "wire/tcp_protocol.h"

namespace tims::io {
namespace tcp_link_test {

using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

constexpr std::size_t kPartsBytes = 1 << 20;
constexpr Address kGui{0x00020000};
constexpr Address kLadar{0x01140000};

// A router with one link.
struct Side {
  Side(const link::Identity& self, const link::LinkSettings& link)
      : router({.address = self.address(), .role = self.role}, core::HashSeed{}, hooks),
        links(router, pool, memory, {.self = self, .secret = {self.epoch, self.id}}) {
    router.attach(core::PortKind::kLocal, hooks);
    router.attach(core::PortKind::kLink, links);
    links.configure(os::now(), {&link, 1});
  }

  core::test::RecordingSink hooks;
  core::Router router;
  Bytes blocks = Bytes(kPartsBytes);
  Bytes parts = Bytes(4 * kPartsBytes);
  core::BlockPool pool{blocks};
  link::MessageMemory memory{parts, 1 << 16, 4 * kPartsBytes};
  link::Links links;
};

link::Identity identity(core::Role role, std::uint16_t system) {
  return {.epoch = 7U + system,
          .role = role,
          .system = system,
          .id = 1,
          .name = std::string_view(system == 0 ? "base" : "robot"),
          .message_max = 1 << 16};
}

// The router below: a test cuts the stream of its datagrams.
class Robot final : private link::DatagramSender {
 public:
  explicit Robot(const link::NetAddress& base)
      : socket_(std::move(
            *os::connect_tcp("127.0.0.1", base.port, os::deadline_after(test::kPatience)))) {
    side_.links.set_sender(link::PathKind::kTcp, this);
    side_.links.set_target(os::now(), "base", base);
    ladar_ = side_.router.connect(os::now(), {.port = core::PortKind::kLocal, .token = 1});
    side_.router.register_mailbox(os::now(), ladar_, kLadar);
  }
  // Whether its link is up after what has come meanwhile.
  bool connects() {
    const Time now = os::now();
    Bytes bytes(1 << 16);
    const ssize_t size = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    const auto come = std::span(bytes).first(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    EXPECT_TRUE(come_.feed(come, [&](std::span<std::byte> datagram) {
      side_.links.on_datagram(now, base_, datagram);
    }));
    side_.links.on_timeout(now);
    side_.links.flush(now);
    side_.links.release();
    write(stream_.size());
    return side_.links.link(0)->is_up();
  }
  // A message in a datagram of its own, at the end of the stream.
  void send(std::uint8_t number) {
    Header header{.type = 3, .priority = 10, .seq_nr = number, .dest = kGui, .src = kLadar};
    header.length = static_cast<std::uint32_t>(kHeaderSize + body(number).size());
    Bytes bytes = core::test::encoded(header, body(number));
    core::Message message{.header = header, .bytes = bytes};
    EXPECT_TRUE(core::taken(side_.router.on_message(os::now(), ladar_, message)));
    side_.links.flush(os::now());
  }
  static Bytes body(std::uint8_t number) {
    Bytes bytes(1200);  // in one datagram
    for (std::size_t i = 0; i < bytes.size(); ++i)
      bytes[i] = static_cast<std::byte>(std::size_t{number} * 50 + i % 251);
    return bytes;
  }
  [[nodiscard]] std::size_t waiting() const { return stream_.size(); }
  void write(std::size_t size) {
    EXPECT_EQ(::send(socket_.get(), stream_.data(), size, MSG_NOSIGNAL),
              static_cast<ssize_t>(size));
    stream_.erase(stream_.begin(), stream_.begin() + static_cast<std::ptrdiff_t>(size));
  }
  void put(std::initializer_list<std::byte> bytes) {
    stream_.insert(stream_.end(), bytes.begin(), bytes.end());
  }

 private:
  bool offer(const link::Burst& burst) override {
    base_ = burst.to;
    burst.for_each(
        [&](std::span<const std::byte> datagram) { link::DatagramStream::put(datagram, stream_); });
    return true;
  }

  os::File socket_;
  link::DatagramStream come_;
  link::NetAddress base_{};
  Bytes stream_;  // not written yet
  Side side_{identity(core::Role::kSystem, 1),
             {.connects = true, .to = "base", .paths = {link::PathKind::kTcp}}};
  core::ClientId ladar_{};
};

class TcpLink : public testing::Test, private TcpPath::Listener {
 protected:
  TcpLink() {
    base_.router.attach(core::PortKind::kTcp, port_);
    base_.links.set_sender(link::PathKind::kTcp, &path_);
    loop_.at_turn_end([this](Time now) {
      base_.router.flush(now);
      path_.flush();
      base_.links.release();
    });
    const auto links = path_.listen({"127.0.0.1", 0});
    const auto clients = port_.listen({"127.0.0.1", 0});
    EXPECT_TRUE(links.ok() && clients.ok());
    gui_ = test::TcpClient::connect(clients->to_string());
    gui_->set_byte_order(std::endian::big);
    constexpr std::array kBody{std::byte{0}, std::byte{2}, std::byte{0}, std::byte{0}};  // kGui
    EXPECT_TRUE(gui_->send({.type = wire::router_command::kMailboxInit}, kBody));
    EXPECT_TRUE(comes_true(
        loop_, [&] { return base_.router.find(kGui) != nullptr; }, "the GUI is registered"));
    robot_.emplace(link::NetAddress::v4(127, 0, 0, 1, links->port));
    EXPECT_TRUE(comes_true(
        loop_, [&] { return robot_->connects(); }, "the robot is linked"));
    // What the link says for itself is not to stand between the messages.
    read_all();
  }

  void read_all() {
    robot_->write(robot_->waiting());
    while (reads_ > 0) {
      reads_ = 0;
      loop_.run_once(os::now() + 1ms);
    }
  }
  // Writes that much of the robot's stream, which the base reads at once.
  void write(std::size_t size) {
    reads_ = 0;
    robot_->write(size);
    EXPECT_TRUE(comes_true(
        loop_, [&] { return reads_ == 1; }, "the base reads"));
  }
  void expect_message(std::uint8_t number) {
    const auto message = gui_->receive();
    ASSERT_TRUE(message.ok()) << message.error().message();
    EXPECT_EQ(message->header.seq_nr, number);
    EXPECT_EQ(message->body, Robot::body(number)) << int{number};
  }

  void on_tcp_datagram(const link::NetAddress& from, std::span<std::byte> datagram) override {
    base_.links.on_datagram(os::now(), from, datagram);
  }
  void on_tcp_gone(const link::NetAddress& address) override {
    base_.links.on_gone(os::now(), address);
    ++gone_;
    // Memory that is free now is soon another's.
    for (std::size_t size = 500; size < 8000; size += 500)
      others_.emplace_back(size, std::byte{0xFF});
  }
  void on_tcp_turn_end() override {
    ++reads_;
    loop_.end_turn(os::now());
  }
  [[nodiscard]] bool is_called(const link::NetAddress&) const override { return false; }
  [[nodiscard]] bool is_linked(const link::NetAddress&) const override { return true; }

  Loop loop_;
  Log log_{config::LogLevel::kError};
  Side base_{identity(core::Role::kTop, 0),
             {.kind = core::LinkKind::kSub, .connects = false, .paths = {link::PathKind::kTcp}}};
  core::QueueShares shares_{base_.pool};
  TcpPort port_{loop_, base_.router, log_, shares_, {}};
  TcpPath path_{loop_, log_, *this};
  Result<test::TcpClient> gui_{Errc::kClosed};
  std::optional<Robot> robot_;
  int reads_ = 0;
  int gone_ = 0;
  std::vector<Bytes> others_;
};

TEST_F(TcpLink, AMessageWhoseEndComesWithTheBeginningOfAnotherIsWhole) {
  for (std::uint8_t number = 1; number <= 3; ++number) robot_->send(number);
  const std::size_t all = robot_->waiting();
  write(all / 6);
  write(4 * all / 6);
  expect_message(1);
  expect_message(2);
  write(robot_->waiting());
  expect_message(3);
}

TEST_F(TcpLink, AMessageIsWholeAlthoughItsConnectionEndsInTheSameTurn) {
  robot_->send(1);
  write(robot_->waiting() / 2);
  robot_->put({std::byte{0}, std::byte{0}});
  write(robot_->waiting());
  EXPECT_EQ(gone_, 1);
  expect_message(1);
}

}  // namespace tcp_link_test
}  // namespace tims::io
