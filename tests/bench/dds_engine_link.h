// Two hosts with nothing but the engine of the router that talks DDS, each turning its own loop.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "libtims/os/clock.h"
#include "router/io/dds/dds_engine.h"
#include "tests/bench/plan.h"

namespace tims::bench {

class DdsEngineLink {
 public:
  static Result<DdsEngineLink> open(const Plan& plan);

  bool send(std::span<const std::byte> payload);
  void flush() {}
  [[nodiscard]] bool needs_credit() const { return false; }

  template <typename Deliver>
  void receive(Duration timeout, Deliver deliver) {
    Host& host = *host_;
    const Time limit = os::deadline_after(timeout);
    while (host.received.size() < payload_) {
      if (limit != kNever && os::now() >= limit) return;
      host.loop.run_once(limit);
    }
    std::size_t at = 0;
    host.received.swap(taken_);
    for (; taken_.size() - at >= payload_; at += payload_)
      deliver(std::span<const std::byte>(taken_).subspan(at, payload_));
    // What has come of the next one stands before what came meanwhile.
    host.received.insert(host.received.begin(), taken_.begin() + static_cast<std::ptrdiff_t>(at),
                         taken_.end());
    taken_.clear();
  }

 private:
  // Messages, all of one size, are a stream: datagrams come complete and in order.
  struct Host final : io::DdsEngine::Listener {
    explicit Host(const Plan& plan);
    void on_datagram(const link::NetAddress&, std::span<std::byte> datagram) override {
      received.insert(received.end(), datagram.begin(), datagram.end());
    }
    void on_announced(const link::Announcement& announcement) override { peer = announcement.dds; }
    void on_gone(const link::NetAddress&) override { peer = {}; }
    void on_state() override {}
    void on_turn_end() override {}

    io::Loop loop;
    io::Log log;
    io::DdsEngine engine;
    link::NetAddress peer{};
    std::vector<std::byte> received{};
  };

  explicit DdsEngineLink(const Plan& plan)
      : payload_(plan.payload), host_(std::make_unique<Host>(plan)) {}

  std::size_t payload_;
  std::unique_ptr<Host> host_;
  std::vector<std::byte> taken_{};
};

}  // namespace tims::bench
