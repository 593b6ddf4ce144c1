// Between the router, which decides, and the ports, which carry out: hands each decision to the
// port of the client it concerns.
#pragma once

#include <array>
#include <functional>

#include "router/core/sink.h"
#include "router/io/port.h"

namespace tims::io {

class Switchboard final : public core::Sink {
 public:
  // Set up before traffic starts. A port that is switched off is not attached, and has no clients.
  void attach(core::PortKind kind, Port& port) { ports_[index(kind)] = &port; }
  void on_admin(std::function<void(core::ClientId, const core::Message&)> action) {
    on_admin_ = std::move(action);
  }
  void on_may_ask(std::function<bool(core::ClientId, const core::Message&)> question) {
    on_may_ask_ = std::move(question);
  }
  void on_traced(std::function<void(core::ClientId, core::ClientId, const core::Message&)> action) {
    on_traced_ = std::move(action);
  }
  void on_event(std::function<void(const core::Event&)> action) { on_event_ = std::move(action); }

  void flush(Time now) {
    for (Port* port : ports_) {
      if (port != nullptr) port->flush(now);
    }
  }
  void stop_accepting() {
    for (Port* port : ports_) {
      if (port != nullptr) port->stop_accepting();
    }
  }
  [[nodiscard]] bool drained() const {
    for (const Port* port : ports_) {
      if (port != nullptr && !port->drained()) return false;
    }
    return true;
  }
  [[nodiscard]] std::uint64_t queued_bytes(core::PortKind kind, std::uint32_t token) const {
    const Port* port = ports_[index(kind)];
    return port == nullptr ? 0 : port->queued_bytes(token);
  }

  core::Outcome deliver(const core::Receiver& to, const core::Message& message) override {
    return port_of(to).deliver(to, message);
  }
  void reply(const core::Receiver& to, const Header& header) override {
    port_of(to).reply(to, header);
  }
  void close(const core::Receiver& client, core::CloseReason reason) override {
    port_of(client).close(client, reason);
  }
  void admin(core::ClientId from, const core::Message& request) override {
    on_admin_(from, request);
  }
  bool may_ask(core::ClientId from, const core::Message& request) override {
    return on_may_ask_(from, request);
  }
  void traced(core::ClientId from, core::ClientId to, const core::Message& message) override {
    on_traced_(from, to, message);
  }
  void moved(Address address) override {
    for (Port* port : ports_) {
      if (port != nullptr) port->moved(address);
    }
  }
  void event(const core::Event& event) override { on_event_(event); }

 private:
  static std::size_t index(core::PortKind kind) { return static_cast<std::size_t>(kind); }
  // Only attached ports have clients.
  Port& port_of(const core::Receiver& to) { return *ports_[index(to.port)]; }

  std::array<Port*, core::kPortKindCount> ports_{};
  std::function<void(core::ClientId, const core::Message&)> on_admin_ = [](core::ClientId,
                                                                           const core::Message&) {};
  std::function<bool(core::ClientId, const core::Message&)> on_may_ask_ =
      [](core::ClientId, const core::Message&) { return true; };
  std::function<void(core::ClientId, core::ClientId, const core::Message&)> on_traced_ =
      [](core::ClientId, core::ClientId, const core::Message&) {};
  std::function<void(const core::Event&)> on_event_ = [](const core::Event&) {};
};

}  // namespace tims::io
