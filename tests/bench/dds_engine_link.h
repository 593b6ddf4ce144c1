// Two hosts with only the DDS engine of the router, each with its own loop.
#pragma once

#include <cstdint>
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
    while (message_at(host.received, 0).empty()) {
      if (limit != kNever && os::now() >= limit) return;
      host.loop.run_once(limit);
    }
    taken_.clear();
    host.received.swap(taken_);
    std::size_t at = 0;
    for (auto message = message_at(taken_, at); !message.empty();
         message = message_at(taken_, at)) {
      deliver(message);
      at += kSize + message.size();
    }
    // Bytes of the next message precede those that have arrived since.
    host.received.insert(host.received.begin(), taken_.begin() + static_cast<std::ptrdiff_t>(at),
                         taken_.end());
  }

 private:
  // A stream of messages, each after its size: datagrams arrive complete and in order.
  struct Host final : io::DdsEngine::Listener {
    Host();
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

  static constexpr std::size_t kSize = sizeof(std::uint32_t);

  DdsEngineLink() : host_(std::make_unique<Host>()) {}

  // Empty if the message has not arrived completely.
  static std::span<const std::byte> message_at(std::span<const std::byte> bytes, std::size_t at);

  std::unique_ptr<Host> host_;
  std::vector<std::byte> out_{};
  std::vector<std::byte> taken_{};
};

}  // namespace tims::bench
