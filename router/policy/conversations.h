// Who has asked whom within the last minute, so that answers need no rule. A table of fixed size:
// under many questions the oldest of a set of four is forgotten, and its answer needs a rule.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tims/address.h"
#include "tims/time.h"

namespace tims::policy {

class Conversations {
 public:
  static constexpr Duration kTime = std::chrono::seconds(60);
  static constexpr std::size_t kSets = 4096;

  explicit Conversations(std::uint64_t secret) : secret_(secret), sets_(kSets) {}

  // `asker` has asked `other`; also: a sample went from `other` to `asker`.
  void open(Time now, Address asker, Address other) {
    Set& set = set_of(asker, other);
    Entry* oldest = set.data();
    for (Entry& entry : set) {
      if (entry.asker == asker && entry.other == other) {
        entry.until = now + kTime;
        return;
      }
      if (entry.until < oldest->until) oldest = &entry;
    }
    *oldest = {asker, other, now + kTime};
  }
  [[nodiscard]] bool is_open(Time now, Address asker, Address other) const {
    for (const Entry& entry : set_of(asker, other))
      if (entry.asker == asker && entry.other == other) return now < entry.until;
    return false;
  }

 private:
  struct Entry {
    Address asker{};
    Address other{};
    Time until{};
  };
  using Set = std::array<Entry, 4>;

  [[nodiscard]] std::size_t number(Address asker, Address other) const {
    const std::uint64_t both = std::uint64_t{asker.raw()} << 32 | other.raw();
    std::uint64_t mixed = (both ^ secret_) * 0x9E3779B97F4A7C15ULL;
    mixed ^= mixed >> 29;
    return mixed * 0xBF58476D1CE4E5B9ULL >> 52;  // 12 bits: kSets
  }
  Set& set_of(Address asker, Address other) { return sets_[number(asker, other)]; }
  [[nodiscard]] const Set& set_of(Address asker, Address other) const {
    return sets_[number(asker, other)];
  }

  std::uint64_t secret_;
  std::vector<Set> sets_;
};
static_assert(Conversations::kSets == 1U << 12);

}  // namespace tims::policy
