// Queries the routers of a fleet and checks the invariants.
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
  // Requires that the routers are running.
  Judge(const Shape& shape, const timsctl::sim::RunningFleet& fleet,
        const timsctl::Signals& signals, Wrong wrong);

  // Checks the invariants that hold at any time. A router that does not answer is skipped.
  void look();
  // Checks the invariants that hold soon after all faults have ended. Returns the first violation;
  // empty: none.
  std::string not_settled();
  // Whether no message is queued for a link.
  bool nothing_waits();
  // The upper limit of the losses that routers and mailboxes have counted.
  Losses counted_losses();

  // Writes the tables of the routers to files.
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
