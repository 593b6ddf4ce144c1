// Some of a link's lanes, a bit each; read from the most urgent one down.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace tims::link {

class LaneSet {
 public:
  // Goes through the lanes as they were when it began.
  class Iterator {
   public:
    explicit Iterator(std::uint32_t bits) : bits_(bits) {}
    std::size_t operator*() const { return static_cast<std::size_t>(std::bit_width(bits_)) - 1; }
    Iterator& operator++() {
      bits_ &= ~std::bit_floor(bits_);
      return *this;
    }
    bool operator==(const Iterator&) const = default;

   private:
    std::uint32_t bits_;
  };

  void add(std::size_t lane) { bits_ |= std::uint32_t{1} << lane; }
  void remove(std::size_t lane) { bits_ &= ~(std::uint32_t{1} << lane); }
  [[nodiscard]] bool empty() const { return bits_ == 0; }
  [[nodiscard]] Iterator begin() const { return Iterator(bits_); }
  [[nodiscard]] Iterator end() const { return Iterator(0); }

 private:
  std::uint32_t bits_ = 0;
};

}  // namespace tims::link
