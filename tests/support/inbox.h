// What a recording says that one connection receives, held against what it does receive. Pure.
//
// Order matters among messages of one origin: those of one sending connection, and those of the
// router itself. Messages of different origins may come in any order. A message may come before
// the recording mentions it: the replay is faster than the programs were.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "tests/support/message.h"
#include "tests/support/recording.h"

namespace tims::test {

inline constexpr int kFromRouter = -1;

class Inbox {
 public:
  struct Expected {
    const recorded::Line* line = nullptr;  // holds a message from the router
    int origin = kFromRouter;              // the connection that sent it
  };
  struct Arrival {
    OwnedMessage message;
    int line = 0;  // where the replay was
    std::uint64_t number = 0;
  };
  // A difference. Nothing expected: the message is one too many. Nothing got: it is missing. Both:
  // it came out of order, or it came changed.
  struct Finding {
    std::optional<Expected> expected;
    std::optional<Arrival> got;
    bool out_of_order = false;
  };

  void expect(const Expected& expected);
  void arrive(OwnedMessage message, int line);

  // Whether something expected has not come.
  [[nodiscard]] bool is_waiting() const { return !expected_.empty(); }
  // How many have come as expected.
  [[nodiscard]] std::uint64_t matched() const { return matched_; }

  // No longer waits: what has not come is missing.
  void give_up();
  // Nothing more is expected: what came beyond it is one too many.
  void finish();

  std::vector<Finding> take_findings();

 private:
  void match(const Expected& expected, Arrival arrival, bool in_order);

  struct Waiting {
    Expected expected;
    bool overtaken = false;  // something that was sent later is here
  };

  std::deque<Waiting> expected_;               // not here yet, in recorded order
  std::deque<Arrival> early_;                  // not mentioned yet, in the order they came
  std::map<int, std::uint64_t> last_matched_;  // number of the last arrival from each origin
  std::uint64_t arrivals_ = 0;
  std::uint64_t matched_ = 0;
  std::vector<Finding> findings_;
};

// Whether a router may deliver `got` where the original one delivered `recorded`: all but the byte
// order of the header must be the same. Of what the router says itself, no flag counts.
bool is_equivalent(const MessageView& recorded, const MessageView& got, bool by_router);

}  // namespace tims::test
