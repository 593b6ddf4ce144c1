// What this process knows about itself, for those who ask (ADMIN.md).
#pragma once

#include <optional>

#include "os/clock.h"
#include "router/core/router.h"
#include "router/io/admin_source.h"
#include "router/io/link_port.h"
#include "router/io/local_port.h"
#include "router/io/loop.h"

namespace tims::io {

// Where it listens, and what was drawn and read at start.
struct StartInfo {
  Time started{};
  std::uint64_t epoch = 0;
  std::string unix_path{};
  std::string tcp{};
  std::string http{};
  std::string udp{};
};

class ProcessInfo final : public AdminSource {
 public:
  ProcessInfo(core::Router& router, const Loop& loop, const LocalPort& local, LinkPort& links,
              const config::Loaded& configuration)
      : router_(router), loop_(loop), local_(local), links_(links), configuration_(configuration) {}

  StartInfo start{};

  [[nodiscard]] const core::Router& router() const override { return router_; }
  [[nodiscard]] ProcessReport process(Time now) const override;
  [[nodiscard]] const config::Config& config() const override { return configuration_.config; }
  [[nodiscard]] const config::Origins& origins() const override { return configuration_.origins; }
  [[nodiscard]] const link::Links* links() const override { return &links_.links(); }
  [[nodiscard]] std::optional<DdsReport> dds() const override;
  bool act_on_link(std::string_view name, link::Links::Action what) const override {
    return links_.act(os::now(), name, what);
  }
  bool inject_faults(std::string_view name, const link::Faults& faults) const override {
    return links_.inject_faults(name, faults);
  }
  void set_static_routes(const std::vector<core::StaticRoute>& routes) const override {
    router_.set_static_routes(routes);
  }
  [[nodiscard]] std::optional<MailboxFill> fill(std::uint32_t handle) const override {
    return local_.fill(handle);
  }
  [[nodiscard]] MailboxCounts mailbox_counts() const override { return local_.mailbox_counts(); }
  [[nodiscard]] std::uint64_t queued_bytes(core::PortKind port,
                                           std::uint32_t token) const override {
    return router_.queued_bytes(port, token);
  }

 private:
  [[nodiscard]] std::optional<UdpReport> udp_socket() const;

  core::Router& router_;
  const Loop& loop_;
  const LocalPort& local_;
  LinkPort& links_;
  const config::Loaded& configuration_;
};

}  // namespace tims::io
