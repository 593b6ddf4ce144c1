// What an agent does to its host so that changed files take effect: the router reloads or is
// restarted, robots restart the components that changed.
#pragma once

#include <string>
#include <vector>

#include "router/config/load.h"
#include "tools/cli/connection.h"
#include "tools/cli/output.h"
#include "tools/configuration/fleet.h"
#include "tools/configuration/folder.h"

namespace timsctl::configuration {

// The files of the router among these, as it would read them.
tims::config::Loaded load_router(const Texts& files);

class Effects {
 public:
  // `router`: of this host; `signals`: Ctrl-C ends waiting.
  Effects(const Folder& folder, UnixHost router, const Signals& signals)
      : folder_(folder), router_(std::move(router)), signals_(signals) {}

  // Items of `done` in PROTOCOL.md. The files are written already; what cannot be done is an item
  // with ok = false.
  json::array apply(const Texts& before, const Texts& after) const;
  // Fills in what goes over each link now: counted for a second. Links whose router does not answer
  // are left out.
  void measure(std::vector<LinkBudget>& links) const;
  // Whether `timsctl up` runs this file.
  [[nodiscard]] bool is_running(const std::string& file) const;

 private:
  void apply_to_router(const Texts& before, const Texts& after, json::array& done) const;
  void apply_to_robot(const std::string& file, json::array& done) const;
  [[nodiscard]] json::object status() const;
  void restart_router() const;

  const Folder& folder_;
  UnixHost router_;
  const Signals& signals_;
};

}  // namespace timsctl::configuration
