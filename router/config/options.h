// The table of all options. Parsing, --set, --help, the sample file, print_config and reload are
// generated from it: a new key is one more row and one more member of Config, Link or Route.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "router/config/config.h"
#include "router/config/value.h"

namespace tims::config {

enum class Reload : std::uint8_t { kYes, kRestart };

// The description of an option, independent of its storage.
struct Spec {
  std::string_view key{};  // "tcp.queue": table, dot, name
  Kind kind{};
  Range range{};  // kText, kNumber, kDuration and kSize have one
  Reload reload{};
  std::string_view help{};  // one sentence or two
  // Only set where the default depends on the host or on another option:
  std::string_view default_note{};  // description of the default
  std::string_view sample{};        // shown in the sample file, as TOML
  bool is_list = false;             // a text of elements: list_of(); in a file also an array

  [[nodiscard]] std::string_view table() const { return key.substr(0, key.find('.')); }
  [[nodiscard]] std::string_view name() const { return key.substr(key.find('.') + 1); }
};

// `index` selects the item of a list; options outside lists ignore it.
struct Option : Spec {
  Value (*read)(const Config&, std::size_t index);
  void (*write)(Config&, std::size_t index, const Value&);
  bool (*has_value)(const Config&, std::size_t index);  // false: not set, nothing to print

  [[nodiscard]] Value get(const Config& config, std::size_t index = 0) const {
    return read(config, index);
  }
  // Precondition: the value has the right kind and is in range.
  void set(Config& config, const Value& value, std::size_t index = 0) const {
    write(config, index, value);
  }
};

std::span<const Option> options();  // sorted by table
const Option* find_option(std::string_view key);

// An array of tables: [[link]]. Its items come from all files and from `--set
// link='kind=...,...'`, in this order. Changes need no restart, see load.h.
struct List {
  std::string_view name;
  std::string_view help;
  std::string_view sample_items;    // shown in the sample file, as TOML
  std::string_view sample_setting;  // example for --set
  std::span<const Option> options;  // of one item; their keys are "link.kind"
  std::size_t (*size)(const Config&);
  void (*append)(Config&);  // appends an item with the defaults
  void (*copy)(Config& to, const Config& from);
  std::string (*label)(const Config&, std::size_t index);  // identifies an item for users

  [[nodiscard]] const Option* find(std::string_view option_name) const;
};

std::span<const List> lists();
const List* find_list(std::string_view name);
std::string item_key(const List& list, std::size_t index);  // "link[0]"

// One value of a configuration: of an option, or of a list item.
struct Entry {
  std::string key;  // "tcp.queue", "link[0].kind"
  const Option* option = nullptr;
  std::size_t index = 0;

  [[nodiscard]] Value get(const Config& config) const { return option->get(config, index); }
};
std::vector<Entry> entries(const Config& config);  // in the order of the tables

// "tcp.queue  size, 64KiB to 1GiB, default 4MiB\n  Maximum amount ..." for every key.
std::string options_help();

// deploy/router.toml: every key with its help and its default, commented out, followed by
// examples of list items.
std::string sample_file();

}  // namespace tims::config
