// Asks the routers of a fleet whether all is as it must be.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "router/core/types.h"
#include "tests/chaos/board.h"
#include "tests/chaos/plan.h"
#include "tools/cli/admin_client.h"
#include "tools/sim/running_fleet.h"

namespace tims::chaos {

// By class.
using Losses = std::array<std::uint64_t, core::kClasses>;

class Judge {
 public:
  using Wrong = std::function<void(const std::string&)>;
  // The routers run.
  Judge(const Shape& shape, const timsctl::sim::RunningFleet& fleet,
        const timsctl::Signals& signals, Wrong wrong);

  // What must be true at any time. A router that does not answer now is passed over.
  void look();
  // What must be true soon after all is healed: the first thing that is not, empty when all is.
  std::string not_settled();
  // Nothing waits for a link.
  bool nothing_waits();
  // What routers and mailboxes say they have thrown away, at most.
  Losses told_losses();

  // What the routers know, as files.
  void save(const std::string& folder);
  [[nodiscard]] std::size_t memory_max() const { return memory_max_; }

 private:
  struct Router {
    std::unique_ptr<timsctl::Connection> connection;
    timsctl::AdminClient admin;
  };

  void look_at(std::size_t host);
  void look_at_memory(std::size_t host);
  std::string missing_links(std::size_t host);
  std::string wrong_routes(std::size_t host);
  timsctl::json::object ask(std::size_t host, const char* what);

  const Shape& shape_;
  Wrong wrong_;
  std::vector<Router> routers_;
  std::size_t memory_max_ = 0;
};

}  // namespace tims::chaos
