// The one table of options. Parsing, --set, --help, the sample file, print_config and reload are
// made from it: a new key is one more row and one more member of Config.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "router/config/config.h"
#include "router/config/value.h"

namespace tims::config {

enum class Reload : std::uint8_t { kYes, kRestart };

// What can be said about an option without knowing where its value is kept.
struct Spec {
  std::string_view key{};  // "tcp.queue": table, dot, name
  Kind kind{};
  Range range{};  // kText, kNumber, kDuration and kSize have one
  Reload reload{};
  std::string_view help{};  // one sentence or two
  // Only where the default depends on the host:
  std::string_view default_note{};  // what it is, in words
  std::string_view sample{};        // what the sample file shows, as TOML

  [[nodiscard]] std::string_view table() const { return key.substr(0, key.find('.')); }
  [[nodiscard]] std::string_view name() const { return key.substr(key.find('.') + 1); }
};

struct Option : Spec {
  Value (*get)(const Config&);
  void (*set)(Config&, const Value&);  // the value is of the kind and in the range
};

std::span<const Option> options();  // those of one table stand together
const Option* find_option(std::string_view key);

// "tcp.queue  size, 64KiB to 1GiB, default 4MiB\n  What waits ..." for every key.
std::string options_help();

// deploy/router.toml: every key with its help and its default, commented out.
std::string sample_file();

}  // namespace tims::config
