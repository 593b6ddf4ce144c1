// What must not happen while a task works in real time, and where it has. Pure.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rack {

enum class Offence : std::uint8_t {
  kBlocked,    // it gave its CPU away
  kPreempted,  // somebody more important took it: no fault of the place where it was
  kPageFault,
};

// The places of all offences, each once. When there are too many, those that were seen first stay.
class OffencePlaces {
 public:
  static constexpr std::size_t kMax = 64;

  struct Place {
    Offence offence{};
    std::string text;
    std::uint64_t count = 0;
  };
  // True: for the first time.
  bool add(Offence offence, std::string_view text);
  // The most frequent first.
  [[nodiscard]] std::vector<Place> worst(std::size_t max) const;

 private:
  std::vector<Place> places_;
};

// How people read where a thread was, innermost function first: "read < Sweeper::look". Names come
// without parameters; the innards of the standard library are left out, and so is all from
// `outermost` on.
std::string place_text(std::span<const std::string> functions, std::string_view outermost,
                       std::size_t size_max);

// "rack::Sweeper::look(int) const" without what stands in parentheses behind the name.
std::string_view without_parameters(std::string_view function);

}  // namespace rack
