// DDS engines of several routers in one process, over all interfaces of this host.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "os/clock.h"
#include "router/core/random.h"
#include "router/io/dds/dds_engine.h"
#include "tests/support/patience.h"

namespace tims::io {

using Bytes = std::vector<std::byte>;

// A different domain for each process, so that parallel tests do not discover each other.
inline unsigned test_domain() { return static_cast<unsigned>(::getpid()) % 200; }
inline std::string test_fleet(const std::string& name = "fleet") {
  return name + std::to_string(::getpid());
}

inline link::Announcement announcement_of(const std::string& name, const std::string& fleet) {
  return {.fleet = std::string_view(fleet),
          .identity = {.epoch = core::spread(
                           static_cast<std::uint64_t>(os::now().time_since_epoch().count())),
                       .name = std::string_view(name),
                       .message_max = 1 << 20},
          .udp = {link::NetAddress::v4(10, 9, 1, 1, 2010)}};
}

// The engine of one router, and everything it reported.
class Host : public DdsEngine::Listener {
 public:
  struct Arrival {
    link::NetAddress from{};
    Bytes bytes{};
  };

  Host(Loop& loop, const std::string& name, DdsSettings settings = {})
      : self(announcement_of(name, settings.fleet.empty() ? test_fleet() : settings.fleet)),
        engine(loop, log, complete(std::move(settings)), *this) {}

  Result<void> start() { return engine.start(self); }
  [[nodiscard]] bool is_up() const { return engine.state() == DdsEngine::State::kUp; }
  [[nodiscard]] link::NetAddress address() const { return engine.address(); }

  [[nodiscard]] bool sees(const Host& other) const {
    return std::ranges::any_of(seen, [&](const link::Announcement& a) {
      return a.dds == other.address() && a.identity == other.self.identity;
    });
  }
  bool send(const link::NetAddress& to, const Bytes& bytes, std::size_t datagram_size) {
    return engine.send({.to = to, .bytes = bytes, .datagram_size = datagram_size});
  }

  void on_datagram(const link::NetAddress& from, std::span<std::byte> datagram) override {
    if (keeps) arrivals.push_back({from, {datagram.begin(), datagram.end()}});
    bytes_in += datagram.size();
  }
  void on_announced(const link::Announcement& announcement) override {
    on_gone_quietly(announcement.dds);
    seen.push_back(announcement);
  }
  void on_gone(const link::NetAddress& dds) override {
    on_gone_quietly(dds);
    gone.push_back(dds);
  }
  void on_state() override { ++states; }
  void on_turn_end() override { ++turns; }

  Log log{config::LogLevel::kError};
  link::Announcement self;
  DdsEngine engine;
  std::vector<link::Announcement> seen{};  // announced, and not gone since
  std::vector<link::NetAddress> gone{};
  std::vector<Arrival> arrivals{};
  bool keeps = true;  // stores arrivals
  std::uint64_t bytes_in = 0;
  int states = 0;
  int turns = 0;

 private:
  static DdsSettings complete(DdsSettings settings) {
    if (settings.fleet.empty()) settings.fleet = test_fleet();
    if (settings.domain == 0) settings.domain = test_domain();
    return settings;
  }
  void on_gone_quietly(const link::NetAddress& dds) {
    std::erase_if(seen, [&](const link::Announcement& a) { return a.dds == dds; });
  }
};

// Runs the loop until `condition` is true.
template <typename Condition>
testing::AssertionResult run_until(Loop& loop, Condition condition, const char* what,
                                   Duration limit = test::kPatience) {
  const Time end = os::now() + limit;
  while (!condition()) {
    const Time now = os::now();
    if (now >= end) return testing::AssertionFailure() << "condition not met: " << what;
    loop.run_once(now + std::chrono::milliseconds(1));
  }
  return testing::AssertionSuccess();
}

class DdsEngineTest : public testing::Test {
 protected:
  testing::AssertionResult until(const std::function<bool()>& condition, const char* what) {
    return run_until(loop_, condition, what);
  }
  // Starts both and waits until they have discovered each other.
  void meet(Host& a, Host& b) {
    ASSERT_TRUE(a.start());
    ASSERT_TRUE(b.start());
    ASSERT_TRUE(until([&] { return a.is_up() && b.is_up() && a.sees(b) && b.sees(a); },
                      "both have discovered each other"))
        << a.engine.last_error() << b.engine.last_error();
  }

  Loop loop_;
};

}  // namespace tims::io
