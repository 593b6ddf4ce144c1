// Messages between two hosts, for tests that change what connects them.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <span>
#include <thread>

#include "tests/support/eventually.h"
#include "tests/system/host.h"

namespace tims::test {

inline constexpr Address kServer(0x01140000);  // Ladar(1/0), at the robot
inline constexpr Address kClient(0x00020000);  // GUI(0/0), at the base

// Continuous numbered messages from the base to the robot; the receiver checks that none is lost,
// duplicated or overtaken.
class Traffic {
 public:
  Traffic(const Host& from, const Host& to)
      : client_(from.session("client")),
        server_(to.session("server")),
        in_(open(server_, kServer)),
        out_(open(client_, kClient)) {
    EXPECT_TRUE(eventually([&] { return from.knows(kServer); }, "the base knows the server"));
    receiver_ = std::jthread([this](const std::stop_token& end) { receive(end); });
    sender_ = std::jthread([this](const std::stop_token& end) { send(end); });
  }
  // Waits until everything that was sent has arrived.
  void expect_all() {
    sender_.request_stop();
    sender_.join();
    EXPECT_TRUE(eventually([&] { return received_ == sent_; }, "all messages have arrived"))
        << received_ << " of " << sent_;
    receiver_.request_stop();
    receiver_.join();
    EXPECT_EQ(disorder_, 0U);
  }
  [[nodiscard]] std::uint32_t received() const { return received_; }
  // Waits until some more messages have arrived.
  [[nodiscard]] testing::AssertionResult goes_on() const {
    const std::uint32_t before = received_;
    return eventually([&] { return received_ > before + 5; }, "more messages arrive");
  }

 private:
  static Mailbox open(Session& session, Address address) {
    auto opened = session.open({.address = address, .slots = 1024, .body_max = 4});
    EXPECT_TRUE(opened.ok()) << opened.error().message();
    return std::move(*opened);
  }
  void send(const std::stop_token& end) {
    while (!end.stop_requested()) {
      const std::uint32_t next = sent_ + 1;
      if (out_.send({.dest = kServer, .type = -1}, std::as_bytes(std::span(&next, 1))).ok())
        sent_ = next;
      (void)out_.peek_for(std::chrono::milliseconds(2));  // sets the rate; there are no answers
    }
  }
  void receive(const std::stop_token& end) {
    while (!end.stop_requested()) {
      const auto message = in_.peek_for(std::chrono::milliseconds(50));
      if (!message || message->body().size() != 4) continue;
      std::uint32_t number = 0;
      std::memcpy(&number, message->body().data(), sizeof number);
      if (number != received_ + 1) ++disorder_;
      received_ = number;
    }
  }

  Session client_;
  Session server_;
  Mailbox in_;
  Mailbox out_;
  std::atomic<std::uint32_t> sent_ = 0;
  std::atomic<std::uint32_t> received_ = 0;
  std::atomic<std::uint32_t> disorder_ = 0;
  std::jthread receiver_;
  std::jthread sender_;
};

}  // namespace tims::test
