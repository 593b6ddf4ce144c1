// Objects with small numbers. The number of a removed object is used again. A port gives these
// numbers to the router and finds a client by its number in constant time.
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

  // The number that the next object will get.
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
  // Null when no object has this number (any more).
  [[nodiscard]] T* find(Slot slot) const {
    return slot < things_.size() ? things_[slot].get() : nullptr;
  }
  // Precondition: an object has this number.
  void erase(Slot slot) {
    things_[slot].reset();
    free_.push_back(slot);
  }

  template <typename Visit>  // visit(T&) must not add objects
  void for_each(Visit visit) const {
    for (const auto& thing : things_) {
      if (thing) visit(*thing);
    }
  }

 private:
  std::vector<std::unique_ptr<T>> things_;  // by slot
  std::vector<Slot> free_;                  // the number freed last is used first
};

}  // namespace tims::base
