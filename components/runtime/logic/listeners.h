// Who gets a component's data, and which of them (specification, sections 6.2 to 6.7).
//
// A listener has asked for data every so many milliseconds (GET_CONT_DATA) and gets each n-th data
// set, the n that comes nearest to its wish without being slower; or it has asked for the next one
// only (GET_NEXT_DATA). All with the same n get the same data sets. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tims/message.h"

namespace rack {

struct Listener {
  tims::Address mailbox{};
  std::uint8_t priority = 0;  // of the request, and of all that answers it
  std::uint8_t seq_nr = 0;
  std::uint32_t reduction = 1;  // each so many-th data set
  bool once = false;            // one data set, and no more
};

class Listeners {
 public:
  explicit Listeners(std::size_t max);

  enum class Added : std::uint8_t { kNew, kAgain, kFull };
  // GET_CONT_DATA. `granted` is the period in ms; the reduction follows from it.
  Added add(const tims::Header& request, tims::Address mailbox, std::uint32_t reduction);
  // GET_NEXT_DATA: who asked gets the next data set.
  Added add_once(const tims::Header& request);
  // False: it was none.
  bool remove(tims::Address mailbox);
  void clear();  // also begins to count anew

  // Counts a data set, and writes who gets it to `to`, which is as large as max(). Those that
  // wanted one only are listeners no longer.
  std::span<Listener> take_due(std::span<Listener> to);

  [[nodiscard]] std::size_t max() const { return max_; }
  [[nodiscard]] std::span<const Listener> all() const { return listeners_; }

 private:
  Added add(const Listener& wanted);

  const std::size_t max_;
  std::vector<Listener> listeners_;  // in the order they came
  std::uint32_t counter_ = 0;        // of data sets
};

// What a period of `wanted` ms becomes when data come every `own` ms (which is not 0).
constexpr std::uint32_t reduction(std::uint32_t wanted, std::uint32_t own) {
  return wanted < own ? 1 : wanted / own;
}

}  // namespace rack
