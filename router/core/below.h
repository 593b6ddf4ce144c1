// What this router tells the routers above and beside it: every mailbox below it, and each change
// of that, numbered. A neighbour that knows number n is told what has changed since; one that is
// too far behind, everything. So nothing is ever queued for a slow neighbour.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "router/core/neighbour.h"

namespace tims::core {

// One mailbox's part in the hash over a table, which is the exclusive or of all of them. `hops` as
// the router that tells counts them.
std::uint32_t table_hash(Address address, const Origin& origin);

class Below {
 public:
  static constexpr std::uint32_t kRemembered = 8192;  // changes

  Below() : changed_(std::make_unique<std::array<Address, kRemembered>>()) {}

  void added(Address address, const Origin& origin) {
    hash_ ^= table_hash(address, origin);
    ++size_;
    note(address);
  }
  void removed(Address address, const Origin& origin) {
    hash_ ^= table_hash(address, origin);
    --size_;
    note(address);
  }

  [[nodiscard]] std::uint32_t number() const { return number_; }  // of the newest change
  [[nodiscard]] std::uint32_t hash() const { return hash_; }
  [[nodiscard]] std::uint32_t size() const { return size_; }
  // Can the changes after number `n` be told?
  [[nodiscard]] bool remembers(std::uint32_t n) const { return number_ - n <= kRemembered; }
  // What change number `n` was about; remembers(n - 1).
  [[nodiscard]] Address changed(std::uint32_t n) const { return (*changed_)[n % kRemembered]; }

 private:
  void note(Address address) { (*changed_)[++number_ % kRemembered] = address; }

  std::uint32_t number_ = 0;
  std::uint32_t hash_ = 0;
  std::uint32_t size_ = 0;
  std::unique_ptr<std::array<Address, kRemembered>> changed_;
};

}  // namespace tims::core
