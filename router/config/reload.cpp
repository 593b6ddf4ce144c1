#include "router/config/reload.h"

#include <algorithm>

#include <fmt/core.h>

#include "router/config/options.h"

namespace tims::config {
namespace {

// Links that are right for the new values of these may be wrong for the old ones.
bool lists_wait(const Config& before, const Config& after) {
  return before.router.role != after.router.role || before.router.system != after.router.system ||
         before.address != after.address || before.udp != after.udp ||
         before.security != after.security;
}

// The items of one list, before and after. Items are the same when their labels are: the first of
// a label with the first of it, the second with the second.
class ListChanges {
 public:
  ListChanges(const List& list, const Config& before, const Config& after)
      : list_(list), before_(before), after_(after), reloadable_(!lists_wait(before, after)) {}

  std::vector<Change> find() {
    std::vector<bool> found(list_.size(before_));
    std::size_t last = 0;
    bool in_order = true;
    for (std::size_t i = 0; i < list_.size(after_); ++i) {
      const std::size_t old = find_old(found, list_.label(after_, i));
      if (old == found.size()) {
        add(label(after_, i), {}, "added");
        continue;
      }
      found[old] = true;
      in_order = in_order && old >= last;
      last = old;
      compare(old, i);
    }
    for (std::size_t i = 0; i < found.size(); ++i)
      if (!found[i]) add(label(before_, i), {}, "removed");
    if (!in_order) add(std::string(list_.name), {}, "in another order");
    return std::move(changes_);
  }

 private:
  [[nodiscard]] std::size_t find_old(const std::vector<bool>& found,
                                     const std::string& label) const {
    for (std::size_t i = 0; i < found.size(); ++i)
      if (!found[i] && list_.label(before_, i) == label) return i;
    return found.size();
  }

  void compare(std::size_t old, std::size_t now) {
    for (const Option& option : list_.options) {
      const Value old_value = option.get(before_, old);
      const Value new_value = option.get(after_, now);
      if (old_value == new_value) continue;
      add(fmt::format("{} {}", label(after_, now), option.name()), to_toml(old_value),
          to_toml(new_value));
    }
  }

  [[nodiscard]] std::string label(const Config& config, std::size_t index) const {
    return fmt::format("{} {}", list_.name, in_quotes(list_.label(config, index)));
  }

  void add(std::string key, std::string before, std::string after) {
    changes_.push_back({std::move(key), std::move(before), std::move(after), reloadable_});
  }

  const List& list_;
  const Config& before_;
  const Config& after_;
  bool reloadable_;
  std::vector<Change> changes_;
};

}  // namespace

std::vector<Change> changes(const Config& before, const Config& after) {
  std::vector<Change> all;
  for (const Option& option : options()) {
    const Value old_value = option.get(before);
    const Value new_value = option.get(after);
    if (old_value == new_value) continue;
    all.push_back({.key = std::string(option.key),
                   .before = to_toml(old_value),
                   .after = to_toml(new_value),
                   .reloadable = option.reload == Reload::kYes});
  }
  for (const List& list : lists()) {
    auto of_list = ListChanges(list, before, after).find();
    std::ranges::move(of_list, std::back_inserter(all));
  }
  return all;
}

Config reloaded(const Config& running, const Config& wanted) {
  Config config = running;
  for (const Option& option : options())
    if (option.reload == Reload::kYes) option.set(config, option.get(wanted));
  if (lists_wait(running, wanted)) return config;
  for (const List& list : lists()) list.copy(config, wanted);
  return config;
}

std::string Change::to_string() const {
  return fmt::format("{}: {}{}{}{}", key, before, before.empty() ? "" : " -> ", after,
                     reloadable ? "" : ", needs a restart");
}

}  // namespace tims::config
