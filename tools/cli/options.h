// What the command line said, as plain values.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/gdos.h"
#include "tims/time.h"
#include "tools/cli/failure.h"

namespace timsctl {

class Context;

enum class Format : std::uint8_t { kTable, kWide, kPlain, kJson, kCsv, kName };

struct Options {
  // Which router.
  std::string host;    // "", "robot:2000", "unix:/run/tims/router.sock"
  std::string router;  // of the fleet, by name or address: asked through the one of `host`
  tims::Duration timeout = std::chrono::seconds(2);
  bool has_timeout = false;  // somebody has said so

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
  std::vector<std::string> given;  // the options, each in one form: "--count=5", "--json"
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
  std::string world;
  std::string filter;                      // of msg echo
  std::string robot;                       // of nav: a system's number, or the name of a router
  std::string plot;                        // of nav: a picture
  std::optional<tims::Duration> patience;  // of nav goto
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
  bool gps = false;  // of nav goto

  [[nodiscard]] bool json() const { return format == Format::kJson; }
  // Of a verb that repeats something until it is stopped: the number of times it was told.
  [[nodiscard]] bool endless() const { return !count && !run_for; }
};

// The one table of options: how each is written, what it takes, where its value goes.

struct OptionRow {
  std::string_view name;   // "timeout": long name, and how the table of verbs refers to it
  char letter;             // 'n' for -n, 0 without
  std::string_view value;  // "DUR"; empty: a flag. "[2]": may be left out, then it is 2
  std::string_view help;
  // Throws Failure when the value is not one.
  void (*set)(Options& options, std::string_view value);

  // The same, with the option's name in front of what is wrong.
  void apply(Options& options, std::string_view text) const;
  [[nodiscard]] bool takes_value() const { return !value.empty() && !value.starts_with('['); }
};

std::span<const OptionRow> option_table();
const OptionRow* find_option(std::string_view name);
const OptionRow* find_option(char letter);

// What -o calls it.
std::string_view form_name(Format format);

// --- Verbs

// What -o may say: text for people; also a message a line; also rows that are all alike.
inline constexpr std::string_view kTexts = "table wide json";
inline constexpr std::string_view kLines = "table wide json csv";
inline constexpr std::string_view kRows = "table wide plain json csv name";

struct Verb {
  std::string_view noun;
  std::string_view verb;       // empty: the noun is the whole command
  std::string_view arguments;  // "ADDR [TYPE]"
  std::size_t arguments_min;
  std::size_t arguments_max;
  std::string_view options;  // beyond the general ones, as the option table names them
  bool endless;              // runs until Ctrl-C unless told otherwise: then Ctrl-C is its end
  std::string_view help;
  std::string_view example;
  // Null: `program` does it, as "PROGRAM VERB OPTIONS -- ARGUMENTS".
  Exit (*run)(Context& context);
  std::string_view forms = kTexts;  // of -o
  std::string_view program{};       // "timsctl-sim"

  [[nodiscard]] std::string name() const;  // "route show"
  [[nodiscard]] std::string word() const;  // "show"; of a command without verbs its noun
};

// Options every verb takes, and those of every verb that shows something once.
inline constexpr std::string_view kGeneralOptions =
    "host router json json-lines output timeout quiet verbose no-color utc";
inline constexpr std::string_view kShowOptions = "watch count once sort";

// What timsctl-robot and timsctl-sim do: timsctl lists their verbs with its own, and becomes them.
// One without an example is not listed.
std::span<const Verb> program_verbs();

}  // namespace timsctl
