// What the command line said, as plain values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rack/proxies/gdos.h"
#include "tims/time.h"

namespace timsctl {

enum class Format : std::uint8_t { kTable, kWide, kPlain, kJson, kCsv, kName };

struct Options {
  // Which router.
  std::string host;    // "", "robot:2000", "unix:/run/tims/router.sock"
  std::string router;  // of the fleet, by name or address: asked through the one of `host`
  tims::Duration timeout = std::chrono::seconds(2);

  // How things are shown.
  Format format = Format::kTable;
  bool utc = false;
  bool no_color = false;
  bool quiet = false;
  bool verbose = false;
  std::string sort;

  // How often and how long.
  std::optional<tims::Duration> watch;
  std::optional<std::uint64_t> count;
  std::optional<tims::Duration> run_for;
  std::optional<tims::Duration> interval;

  // What single verbs take.
  std::vector<std::string> arguments;
  std::string from;
  std::string type;
  std::string listen;
  std::string hex;
  std::string file;
  std::optional<double> rate_hz;
  std::optional<std::uint8_t> priority;
  std::uint32_t size_bytes = 0;
  std::uint32_t body_max_bytes = 4U << 20;
  tims::Duration period{};
  std::string by;
  std::string style;  // doctor --format
  std::string fleet;  // of sim
  std::string link;   // of sim fault
  std::string on;     // of up: a host
  std::optional<std::int64_t> system;
  std::optional<tims::Duration> wait;  // of component
  std::string component;               // of log: whose texts
  std::optional<rack::gdos::Level> level;
  std::string since;
  std::string until;
  std::string directory;
  std::string filter;  // of msg echo
  bool fields = false;
  bool si = false;
  bool yes = false;
  bool raw = false;
  bool no_wait = false;
  bool dry_run = false;  // of component param save
  bool origin = false;
  bool all_routers = false;
  bool hops = false;
  bool detach = false;

  [[nodiscard]] bool json() const { return format == Format::kJson; }
  // Of a verb that repeats something until it is stopped: the number of times it was told.
  [[nodiscard]] bool endless() const { return !count && !run_for; }
};

}  // namespace timsctl
