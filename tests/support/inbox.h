// Compares the messages that a connection receives with those it received in the recording. Pure.
//
// Messages of one origin must keep their order; an origin is a sending connection or the router
// itself. Messages of different origins may arrive in any order. A message may arrive before its
// line in the recording, because the replay is faster than the programs were.
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
    const recorded::Line* line = nullptr;  // a line with a message from the router
    int origin = kFromRouter;              // the connection that sent it
  };
  struct Arrival {
    OwnedMessage message;
    int line = 0;  // line of the recording at which the replay was
    std::uint64_t number = 0;
  };
  // A difference. Nothing expected: the message is surplus. Nothing received: it is missing. Both:
  // it arrived out of order or changed.
  struct Finding {
    std::optional<Expected> expected;
    std::optional<Arrival> got;
    bool out_of_order = false;
  };

  void expect(const Expected& expected);
  void arrive(OwnedMessage message, int line);

  // Whether an expected message has not arrived.
  [[nodiscard]] bool is_waiting() const { return !expected_.empty(); }
  // The number of messages that arrived as expected.
  [[nodiscard]] std::uint64_t matched() const { return matched_; }

  // Stops waiting: messages that have not arrived are missing.
  void give_up();
  // Nothing more is expected: remaining messages are surplus.
  void finish();

  std::vector<Finding> take_findings();

 private:
  void match(const Expected& expected, Arrival arrival, bool in_order);

  struct Waiting {
    Expected expected;
    bool overtaken = false;  // a message that was sent later has arrived
  };

  std::deque<Waiting> expected_;  // not received yet, in recorded order
  std::deque<Arrival> early_;     // not reached in the recording yet, in order of arrival
  std::map<int, std::uint64_t> last_matched_;  // number of the last arrival from each origin
  std::uint64_t arrivals_ = 0;
  std::uint64_t matched_ = 0;
  std::vector<Finding> findings_;
};

// Whether a router may deliver `got` where the original one delivered `recorded`: everything except
// the byte order of the header must be equal. The flags of the router's own messages are ignored.
bool is_equivalent(const MessageView& recorded, const MessageView& got, bool by_router);

}  // namespace tims::test
