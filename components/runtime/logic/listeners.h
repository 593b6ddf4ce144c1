// The listeners of a component and the data sets that each of them gets (specification, sections
// 6.2 to 6.7).
//
// A listener has requested data with a period (GET_CONT_DATA) and gets every n-th data set, with
// the largest n that is not slower than requested; or it has requested the next data set only
// (GET_NEXT_DATA). All listeners with the same n get the same data sets.
//
// When all places are taken and another component requests one, listeners that get data rarely are
// checked for existence (take_rare), and the component that has most places gives one (make_place).
// Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tims/message.h"
#include "tims/time.h"

namespace rack {

struct Listener {
  tims::Address mailbox{};
  tims::Address source{};     // the component that requested the data
  std::uint8_t priority = 0;  // of the request and of all its answers
  std::uint8_t seq_nr = 0;
  std::uint32_t reduction = 1;  // every n-th data set
  bool once = false;            // one data set only
  tims::Time requested{};       // last
};

class Listeners {
 public:
  explicit Listeners(std::size_t max);

  // kChanged: it was one at another period.
  enum class Added : std::uint8_t { kNew, kChanged, kAgain, kFull };
  // GET_CONT_DATA of the component `source`.
  Added add(const tims::Header& request, tims::Address source, tims::Address mailbox,
            std::uint32_t reduction, tims::Time now = {});
  // GET_NEXT_DATA: the sender gets the next data set.
  Added add_once(const tims::Header& request, tims::Address source, tims::Time now = {});

  // Writes the listeners whose last data set was not the newest to `to`, which has room for max()
  // listeners: whether they still exist is not known. Empty when it was called since the newest.
  std::span<Listener> take_rare(std::span<Listener> to);
  // Removes and returns the newest listener of the component with most of them, if `source` still
  // has fewer with one more. Empty: `source` has its share.
  std::optional<Listener> make_place(tims::Address source);
  // False: it was not a listener.
  bool remove(tims::Address mailbox);
  // A router reports that the mailbox does not exist. The report may be older than the last
  // request, for example of a program that was restarted; if so, it is repeated after later data.
  static constexpr tims::Duration kReportMayBeOld = std::chrono::seconds(1);
  bool remove_gone(tims::Address mailbox, tims::Time now);
  void clear();  // also resets the count

  // Counts a data set, and writes its receivers to `to`, which has room for max() listeners.
  // Listeners of one data set only are removed.
  std::span<Listener> take_due(std::span<Listener> to);

  [[nodiscard]] std::size_t max() const { return max_; }
  [[nodiscard]] std::span<const Listener> all() const { return listeners_; }

 private:
  Added add(const Listener& wanted);
  [[nodiscard]] std::size_t places_of(tims::Address source) const;

  const std::size_t max_;
  std::vector<Listener> listeners_;  // in the order they came
  std::uint32_t counter_ = 0;        // number of data sets
  bool rare_taken_ = false;          // since the newest data set
};

// The reduction for a requested period of `wanted` ms when data have a period of `own` ms (not 0).
constexpr std::uint32_t reduction(std::uint32_t wanted, std::uint32_t own) {
  return wanted < own ? 1 : wanted / own;
}

}  // namespace rack
