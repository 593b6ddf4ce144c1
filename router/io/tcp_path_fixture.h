// For tests: the path over TCP, on loopback: one router's end, and what arrived there.
#pragma once

#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "os/clock.h"
#include "router/io/net/addresses.h"
#include "router/io/tcp_path.h"
#include "tests/support/eventually.h"

namespace tims::io {

// Runs the loop until it is so.
template <typename Condition>
testing::AssertionResult comes_true(Loop& loop, Condition condition, const char* what) {
  return test::eventually(
      [&] {
        loop.run_once(os::now() + std::chrono::milliseconds(1));
        return condition();
      },
      what);
}

class TcpHost : public TcpPath::Listener {
 public:
  struct Arrival {
    link::NetAddress from{};
    std::vector<std::byte> bytes{};
  };

  explicit TcpHost(Loop& loop) : path(loop, log, *this) {
    auto where = path.listen({"127.0.0.1", 0});
    EXPECT_TRUE(where.ok()) << where.error().message();
    address = link::NetAddress::v4(127, 0, 0, 1, where->port);
    address.kind = link::PathKind::kTcp;
  }

  bool send(const link::Burst& burst) {
    const bool accepted = path.offer(burst);
    path.flush();
    return accepted;
  }

  void on_tcp_datagram(const link::NetAddress& from, std::span<std::byte> datagram) override {
    arrivals.push_back({from, {datagram.begin(), datagram.end()}});
  }
  void on_tcp_gone(const link::NetAddress& gone_address) override { gone.insert(gone_address); }
  void on_tcp_turn_end() override { path.flush(); }
  // Only listening ports are called.
  [[nodiscard]] bool is_called(const link::NetAddress& to) const override {
    return calls && to.ip == address.ip;
  }
  [[nodiscard]] bool is_linked(const link::NetAddress& from) const override {
    return linked.contains(from);
  }

  Log log{config::LogLevel::kError};
  TcpPath path;
  link::NetAddress address{};
  std::vector<Arrival> arrivals{};
  std::set<link::NetAddress> gone{};
  std::set<link::NetAddress> linked{};
  bool calls = true;
};

}  // namespace tims::io
