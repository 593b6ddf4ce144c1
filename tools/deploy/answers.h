// What on_host.sh answers: lines of words. They come from another host, so that everything is
// bounded and checked; unknown lines are left out. Pure.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/deploy/host_run.h"

namespace timsctl::deploy {

// Of one answer, in bytes: 64 configuration files in hex, and names.
inline constexpr std::size_t kAnswerMax = 16U << 20;

// A file below /etc/tims.
struct HostFile {
  std::string sha256{};             // hex
  std::optional<std::string> text;  // of configuration files; never of keys
};

struct Facts {
  bool complete = false;       // the answer has its end
  std::string architecture{};  // "amd64"
  bool interrupted = false;    // a former deployment has not ended
  bool can_undo = false;
  std::map<std::string, std::string> packages{};  // ours, installed: name, version
  std::map<std::string, HostFile> files{};
  std::map<std::string, std::string> deployed{};  // files of the last deployment: name, SHA-256
  std::map<std::string, std::string> debs{};      // that were carried there: name, SHA-256
};
Facts facts_of(std::string_view answer);

struct PackageChange {
  std::string name{};
  std::string before{};  // version; empty: not installed
  std::string after{};   // empty: removed
  bool operator==(const PackageChange&) const = default;
};
std::vector<PackageChange> changes_of(std::string_view answer);

struct Progress {
  std::vector<std::string> steps{};  // "installing"
  std::vector<std::string> log{};    // its last lines
  End end = End::kNone;
  std::string reason{};
};
Progress progress_of(std::string_view answer);

// The reason in what a failed step has printed: the line of on_host.sh, else the last line.
std::string reason_in(std::string_view errors);

// Names that are accepted below /etc/tims: router.toml, and files in router.d, robots, keys.
bool is_deployed_name(std::string_view name);

}  // namespace timsctl::deploy
