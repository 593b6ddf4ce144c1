// The routers that mailboxes behind links live at: a short list with numbers, so that a mailbox
// needs no more than one of them.
#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "router/core/neighbour.h"

namespace tims::core {

class Origins {
 public:
  // A number for this origin, held until release().
  std::uint32_t hold(const Origin& origin) {
    const auto [place, added] = numbers_.try_emplace(key(origin), 0);
    if (added) {
      if (free_.empty()) {
        place->second = static_cast<std::uint32_t>(list_.size());
        list_.emplace_back();
      } else {
        place->second = free_.back();
        free_.pop_back();
      }
      list_[place->second] = {origin, 0};
    }
    ++list_[place->second].held;
    return place->second;
  }
  void release(std::uint32_t number) {
    Item& item = list_[number];
    if (--item.held > 0) return;
    numbers_.erase(key(item.origin));
    free_.push_back(number);
  }
  [[nodiscard]] const Origin& at(std::uint32_t number) const { return list_[number].origin; }
  [[nodiscard]] std::size_t size() const { return numbers_.size(); }

 private:
  using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint8_t>;
  struct Item {
    Origin origin{};
    std::uint32_t held = 0;
  };
  static Key key(const Origin& o) { return {o.router.raw(), o.epoch, o.hops}; }

  std::map<Key, std::uint32_t> numbers_;
  std::vector<Item> list_;
  std::vector<std::uint32_t> free_;
};

}  // namespace tims::core
