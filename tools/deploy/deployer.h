// A deployment that runs: ssh to all hosts at once, what they answer, and what is shown of it.
#pragma once

#include <string>
#include <vector>

#include "tools/cli/context.h"
#include "tools/deploy/answers.h"
#include "tools/deploy/order.h"
#include "tools/deploy/remote.h"
#include "tools/deploy/rollout.h"

namespace timsctl::deploy {

class Deployer {
 public:
  Deployer(Context& context, Order order);
  ~Deployer();
  Deployer(const Deployer&) = delete;
  Deployer& operator=(const Deployer&) = delete;

  // Throws Interrupted after Ctrl-C, when all hosts are as they were, or at the second one.
  Exit run();

 private:
  struct Host {
    Target target;
    Remote remote;
    Facts facts{};
    std::vector<Package> packages{};       // to be sent
    std::vector<PackageChange> changes{};  // what apt will do
    std::vector<std::string> steps{};      // of its job
    std::vector<std::string> log{};
  };

  bool turn();  // whether it goes on
  void begin(std::size_t number, Step step);
  void take(std::size_t number);
  void take_answer(std::size_t number);
  void looked(std::size_t number);
  void stop();

  void send(Host& host, const std::string& verb, std::string_view more, std::string_view input);
  [[nodiscard]] std::string staged(const Host& host) const;
  [[nodiscard]] std::string carried(const Host& host, std::size_t index) const;

  // Whether the hosts shall be changed, after the plan was shown.
  bool is_wanted();
  [[nodiscard]] std::string plan_text() const;
  [[nodiscard]] std::string plan_of(const Host& host) const;
  [[nodiscard]] json::object item(std::size_t number) const;
  [[nodiscard]] std::string state_of(std::size_t number) const;
  void show_progress();
  void report();

  Context& context_;
  Order order_;
  std::vector<Host> hosts_{};
  Rollout rollout_;
  std::string id_;
  std::string who_;
  std::string folder_;  // of the sockets
  std::vector<std::string> shown_{};
  bool undo_;
  bool stopped_ = false;
};

}  // namespace timsctl::deploy
