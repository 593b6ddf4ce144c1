// Routers of several hosts, each a process, connected by real UDP over the loopback.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/router_process.h"
#include "tims/session.h"

namespace tims::test {

inline std::string last_field(const std::string& line) { return line.substr(line.rfind(' ') + 1); }

// A router of the tree. It keeps its UDP port over a restart.
class Host {
 public:
  Host(std::string name, std::string role, int system, int id, std::vector<std::string> links,
       const std::vector<std::string>& more = {})
      : name_(std::move(name)),
        settings_{"security.insecure=false", "router.name=" + name_,
                  "router.role=" + std::move(role), "router.system=" + std::to_string(system),
                  "router.id=" + std::to_string(id)} {
    settings_.insert(settings_.end(), more.begin(), more.end());
    for (std::string& link : links) settings_.push_back("link=" + std::move(link));
  }

  void start() {
    std::vector<std::string> settings = settings_;
    settings.push_back("udp.listen=" + udp_);
    router_ = std::make_unique<RouterProcess>(settings);
    const auto started = router_->start();
    ASSERT_TRUE(started.ok()) << started.error().message();
    const auto line = router_->process().wait_for_line("listening udp");
    ASSERT_TRUE(line.ok()) << line.error().message();
    udp_ = last_field(*line);
  }
  void kill() { router_->kill(); }
  [[nodiscard]] ChildProcess& process() { return router_->process(); }
  void listen_at(std::string udp) { udp_ = std::move(udp); }
  [[nodiscard]] const std::string& udp() const { return udp_; }
  [[nodiscard]] std::string socket() const { return router_->socket_path(); }
  [[nodiscard]] const std::string& tcp() const { return router_->tcp(); }
  [[nodiscard]] std::string log() { return router_->process().output(); }

  Session session(const std::string& name) const {
    auto connected = Session::connect({.name = name,
                                       .router = socket(),
                                       .timeout = kPatience,
                                       .on_event = [](const SessionEvent&) {}});
    EXPECT_TRUE(connected.ok()) << connected.error().message();
    return std::move(*connected);
  }
  // The output of timsctl at this router; the exit status is ignored.
  std::string timsctl(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {TIMSCTL_PROGRAM, "-H", "unix:" + socket()});
    if (!arguments.back().starts_with("--timeout="))
      arguments.push_back("--timeout=" + std::to_string(kPatienceMs) + "ms");
    auto child = ChildProcess::start(std::move(arguments));
    if (!child) return child.error().message();
    (void)child->wait();
    return child->standard_output() + child->standard_error();
  }
  bool knows(Address address) const {
    return timsctl({"route", "show", "--json"}).find("\"" + address.to_hex() + "\"") !=
           std::string::npos;
  }

 private:
  std::string name_;
  std::vector<std::string> settings_;
  std::string udp_ = "127.0.0.1:0";
  std::unique_ptr<RouterProcess> router_;
};

}  // namespace tims::test
