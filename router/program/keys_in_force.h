// The keys of this router (security.keys) in force at all of its ports: when they are loaded, when
// they change on the disk, when a newer list of the fleet comes, and their renewal in time. Without
// security.keys, none of this exists.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "router/config/config.h"
#include "router/config/networks.h"
#include "router/io/admin_source.h"
#include "router/io/http/http_port.h"
#include "router/io/link_port.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/io/member_keys.h"
#include "router/io/renewal.h"
#include "router/io/tcp_port.h"
#include "router/io/tls_gate.h"

namespace tims::program {

class KeysInForce {
 public:
  struct Ports {
    io::LinkPort& links;
    io::TcpPort& tcp;
    io::HttpPort& http;
  };

  // `config`: the running configuration.
  KeysInForce(io::Loop& loop, io::Log& log, io::LimitedLog& limited_log,
              const config::Config& config);

  // Before the ports listen. Succeeds without security.keys; then exist() stays false.
  Result<void> load(const Ports& ports);
  [[nodiscard]] bool exist() const { return keys_.has_value(); }

  // The running configuration has changed.
  void configure();
  // A list that a link has brought.
  void take_list(Time now, io::CheckedList&& list);

  void add_to(io::ProcessReport& report) const;

 private:
  void renew_in_time();
  [[nodiscard]] Time renewal_time() const;
  [[nodiscard]] bool is_renewal_due() const;
  [[nodiscard]] std::vector<std::string> hosts_above() const;
  [[nodiscard]] Result<io::TlsGate::Contexts> tls_contexts() const;
  Result<void> open_gate();
  void look(Time now);
  void look_at_age_of_list();
  void use_new(Time now);
  void replace_at_gate();
  [[nodiscard]] std::string description() const;
  [[nodiscard]] std::string old_list_text() const;

  io::Loop& loop_;
  io::Log& log_;
  io::LimitedLog& limited_log_;
  const config::Config& config_;
  config::Networks plain_networks_;  // TCP without TLS
  std::optional<Ports> ports_;
  std::optional<io::MemberKeys> keys_;
  bool list_is_old_ = false;
  std::vector<security::Certificate> believed_;  // roots, when the keys were taken last
  std::unique_ptr<io::TlsGate> gate_;
  std::optional<io::Renewal> renewal_;  // empty: at the base
};

}  // namespace tims::program
