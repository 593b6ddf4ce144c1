// The DDS path under the links: what the engine brings goes to the links, and what they send by DDS
// goes to the engine.
#pragma once

#include <vector>

#include "router/config/config.h"
#include "router/io/dds/dds_engine.h"
#include "router/link/links.h"

namespace tims::io {

class DdsPath final : public link::DatagramSender, private DdsEngine::Listener {
 public:
  DdsPath(Loop& loop, Log& log, link::Links& links, const config::Config& config);

  // `udp`: where this router takes datagrams.
  Result<void> start(std::vector<link::NetAddress> udp);
  // This host may have other addresses now.
  void network_changed(std::vector<link::NetAddress> udp);
  void stop() { engine_.stop(); }

  // One that the engine does not take is lost, as it might be on its way.
  bool offer(const link::Burst& burst) override {
    (void)engine_.send(burst);
    return true;
  }

  [[nodiscard]] const DdsEngine& engine() const { return engine_; }

 private:
  // DdsEngine::Listener
  void on_datagram(const link::NetAddress& from, std::span<std::byte> datagram) override;
  void on_announced(const link::Announcement& announcement) override;
  void on_gone(const link::NetAddress& dds) override;
  void on_state() override;
  void on_turn_end() override;

  Loop& loop_;
  Log& log_;
  link::Links& links_;
  link::Announcement self_;
  std::vector<link::NetAddress> host_;  // all addresses when the engine looked at its interfaces
  DdsEngine engine_;
};

}  // namespace tims::io
