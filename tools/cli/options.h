// The options of the command line as plain values, and the tables of options and verbs.
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
  std::string router;  // another router of the fleet, by name or address, asked through the router
                       // of `host`
  tims::Duration timeout = std::chrono::seconds(2);
  bool has_timeout = false;  // --timeout was given

  // Output.
  Format format = Format::kTable;
  bool utc = false;
  bool no_color = false;
  bool quiet = false;
  bool verbose = false;
  std::string sort;

  // Repetition.
  std::optional<tims::Duration> watch;
  std::optional<std::uint64_t> count;
  std::optional<tims::Duration> run_for;
  std::optional<tims::Duration> interval;

  // Options of single verbs.
  std::vector<std::string> arguments;
  std::vector<std::string> given;  // the given options in long form: "--count=5", "--json"
  std::string from;
  std::string to;
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
  std::string component;               // of log: pattern of senders
  std::optional<rack::gdos::Level> level;
  std::string since;
  std::string until;
  std::string directory;
  std::string world;
  std::string filter;                      // of msg echo
  std::string robot;                       // of nav: a system's number, or the name of a router
  std::string plot;                        // of nav: a picture
  std::string objects;                     // of camera save: what recognises them
  std::optional<tims::Duration> patience;  // of nav goto
  std::string why;                         // of config apply
  std::string keys;                        // of key, token, join: a folder
  std::string role;                        // likewise: of the member
  std::optional<std::int64_t> id;
  std::string name;
  std::string rights;
  std::string address;  // of token new, web
  bool bearer = false;  // of web
  tims::Duration window = std::chrono::seconds(90);
  std::optional<std::uint64_t> generation;  // of config undo
  bool fields = false;
  bool si = false;
  bool newest = false;  // of component data
  bool yes = false;
  bool raw = false;
  bool no_wait = false;
  bool anyway = false;   // of nav goto
  bool dry_run = false;  // of component param save, deploy
  bool origin = false;
  bool all_routers = false;
  bool hops = false;
  bool detach = false;
  bool gps = false;         // of nav goto
  bool finish = false;      // of key rotate
  bool force = false;       // of key rotate --finish, key import, deploy
  bool undo = false;        // of deploy
  bool until_idle = false;  // of key serve
  bool insecure = false;    // of sim up

  [[nodiscard]] bool json() const { return format == Format::kJson; }
  // Whether a verb that repeats something runs until it is stopped.
  [[nodiscard]] bool endless() const { return !count && !run_for; }
};

// The table of all options: names, value, help, and where the value is stored.

struct OptionRow {
  std::string_view name;   // "timeout": the long name; the table of verbs refers to it
  char letter;             // 'n' for -n; 0: no short form
  std::string_view value;  // "DUR"; empty: a flag. "[2]": optional, 2 by default
  std::string_view help;
  // Throws Failure if the value is invalid.
  void (*set)(Options& options, std::string_view value);

  // Calls set(); error messages start with the name of the option.
  void apply(Options& options, std::string_view text) const;
  [[nodiscard]] bool takes_value() const { return !value.empty() && !value.starts_with('['); }
};

std::span<const OptionRow> option_table();
const OptionRow* find_option(std::string_view name);

// The name of a format for -o.
std::string_view form_name(Format format);

// --- Verbs

// The forms of -o that a verb supports: one object; also one message per line; also a list of rows.
inline constexpr std::string_view kTexts = "table wide json";
inline constexpr std::string_view kLines = "table wide json csv";
inline constexpr std::string_view kRows = "table wide plain json csv name";

struct Verb {
  std::string_view noun;
  std::string_view verb;       // empty: the noun is the whole command
  std::string_view arguments;  // "ADDR [TYPE]"
  std::size_t arguments_min;
  std::size_t arguments_max;
  std::string_view options;  // in addition to the general ones, by their long names
  bool endless;              // runs until Ctrl-C unless limited; Ctrl-C is then its normal end
  std::string_view help;
  std::string_view example;
  // Null: `program` implements it, called as "PROGRAM VERB OPTIONS -- ARGUMENTS".
  Exit (*run)(Context& context);
  std::string_view forms = kTexts;  // of -o
  std::string_view program{};       // "timsctl-sim"

  [[nodiscard]] std::string name() const;        // "route show"
  [[nodiscard]] std::string short_name() const;  // "show"; the noun of a command without verbs
};

// Options of all verbs, and options of all verbs that show a state.
inline constexpr std::string_view kGeneralOptions =
    "host router json json-lines output timeout quiet verbose no-color utc";
inline constexpr std::string_view kShowOptions = "watch count once sort";

// The verbs of timsctl-robot, timsctl-deploy and timsctl-sim. timsctl lists them with its own verbs
// and executes the program. Verbs without an example are not listed.
std::span<const Verb> program_verbs();

}  // namespace timsctl
