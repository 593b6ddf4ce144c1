// Things that others know by a small number: what goes leaves its number to what comes next. A port
// gives such numbers to the router and finds its client by them with one look.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace tims::base {

template <typename T>
class SlotMap {
 public:
  using Slot = std::uint32_t;

  // The number that the next thing will get.
  [[nodiscard]] Slot next() const {
    return free_.empty() ? static_cast<Slot>(things_.size()) : free_.back();
  }
  T& add(std::unique_ptr<T> thing) {
    const Slot slot = next();
    if (free_.empty()) {
      things_.emplace_back();
    } else {
      free_.pop_back();
    }
    things_[slot] = std::move(thing);
    return *things_[slot];
  }
  // Null when nothing has this number (any more).
  [[nodiscard]] T* find(Slot slot) const {
    return slot < things_.size() ? things_[slot].get() : nullptr;
  }
  // Something has it.
  void erase(Slot slot) {
    things_[slot].reset();
    free_.push_back(slot);
  }

  template <typename Visit>  // (T&); adds nothing
  void for_each(Visit visit) const {
    for (const auto& thing : things_) {
      if (thing) visit(*thing);
    }
  }

 private:
  std::vector<std::unique_ptr<T>> things_;  // by slot
  std::vector<Slot> free_;                  // the one left last is given first
};

}  // namespace tims::base
