// What is to be deployed: read from a robot file, and from the folders that it names.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/cli/context.h"
#include "tools/deploy/repository.h"

namespace timsctl::deploy {

inline constexpr std::size_t kFileMax = 4U << 20;  // bytes
inline constexpr std::size_t kFilesMax = 64;       // of a host

struct Target {
  std::string name;  // as in the robot file; "main" for [deploy]
  std::string ssh;
  std::vector<std::string> packages;
  std::map<std::string, std::string> files;  // content by name below /etc/tims
};

struct Order {
  std::string robot;
  std::vector<Target> targets;
  std::string source;             // line of sources.list; empty: what the hosts' apt knows
  std::string folder;             // of packages that are carried; empty: none are
  std::vector<Package> packages;  // in that folder
};

// Of the hosts of --on, if it is given. Throws Failure: the file or a folder cannot be read or has
// errors, there is no host.
Order read_order(const Context& context);

}  // namespace timsctl::deploy
