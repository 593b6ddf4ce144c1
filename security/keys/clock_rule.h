// What a verifier may conclude from a certificate's dates. Boards without a battery start in 1970,
// and a robot must not stop for the sake of a clock: dates count only if the clock can be trusted.
#pragma once

#include <cstdint>

namespace tims::security {

// Seconds since 1970.
struct ClockFacts {
  std::int64_t system = 0;
  bool synchronised = false;  // the kernel's clock is disciplined by NTP, GPS, ...
  // The newest moment that has certainly passed: the program was built, own and issuing certificate
  // were made, the newest list was signed.
  std::int64_t passed = 0;
};

struct CheckTime {
  std::int64_t now = 0;  // never before ClockFacts::passed
  bool trusted = false;
  bool operator==(const CheckTime&) const = default;
};
constexpr CheckTime check_time(const ClockFacts& facts) {
  return {facts.system > facts.passed ? facts.system : facts.passed,
          facts.synchronised && facts.system >= facts.passed};
}

enum class Validity : std::uint8_t {
  kValid,
  kEnding,  // less than a tenth of the life is left
  kExpired,
  kNotYet,
  kUnchecked,  // the clock is not trusted
};
// not_before <= not_after; both ends are valid.
constexpr Validity validity(const CheckTime& time, std::int64_t not_before,
                            std::int64_t not_after) {
  if (!time.trusted) return Validity::kUnchecked;
  if (time.now < not_before) return Validity::kNotYet;
  if (time.now > not_after) return Validity::kExpired;
  const auto life = static_cast<std::uint64_t>(not_after) - static_cast<std::uint64_t>(not_before);
  const auto left = static_cast<std::uint64_t>(not_after) - static_cast<std::uint64_t>(time.now);
  return left < life / 10 ? Validity::kEnding : Validity::kValid;
}

// Own certificates are due to be renewed at half of their life; with a clock that is not trusted,
// later.
constexpr bool is_renewal_due(const CheckTime& time, std::int64_t not_before,
                              std::int64_t not_after) {
  return time.trusted && time.now > not_before + (not_after - not_before) / 2;
}

// What the system says now; `passed` as in ClockFacts. Reads the clock and the kernel's opinion of
// it.
CheckTime system_check_time(std::int64_t passed);

}  // namespace tims::security
