// One change of the configuration files of a host, which goes back by itself unless it is confirmed
// in time. Pure: times come as arguments, and what is to be done comes out as steps.
//
// A change replaces one generation of all files by the next. It is applied in two phases: the files
// are written and the programs restarted; then the host waits for a confirmation, which proves that
// whoever made the change can still reach it. Without one, it writes the files of before again.
// Everything that must survive a crash is in Record, and a record is on the disk before what it
// announces is done. So after a crash between any two steps the record tells what to do: a change
// that was not confirmed goes back.
//
// A change on several hosts (rollout.h) is kept on all of them or on none. A host that is confirmed
// asks the others until each says that it is confirmed too (settling); a host that went back tells
// the others, until each has heard it, and they go back as well. Going back always wins: so hosts
// that lose each other in the middle of it agree when they meet again.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tims/time.h"

namespace timsctl::configuration {

using Generation = std::uint64_t;  // 0: there is none

// The least window that an agent may be told to allow, and the usual one.
inline constexpr tims::Duration kWindowMin = std::chrono::seconds(3);
inline constexpr tims::Duration kLeastWindow = std::chrono::seconds(30);
inline constexpr tims::Duration kWindowMax = std::chrono::seconds(600);
inline constexpr tims::Duration kWindow = std::chrono::seconds(90);
inline constexpr tims::Duration kLockMax = std::chrono::seconds(600);
inline constexpr tims::Duration kSettleTime = std::chrono::seconds(30);
inline constexpr tims::Duration kAskPeers = std::chrono::seconds(2);
inline constexpr tims::Duration kTellPeersMost = std::chrono::seconds(60);
inline constexpr std::size_t kGenerationsKept = 20;
inline constexpr std::size_t kOthersMax = 64;

enum class Outcome : std::uint8_t { kPending, kConfirmed, kWentBack, kFound };
std::string_view name_of(Outcome outcome);
std::optional<Outcome> outcome_of(std::string_view name);

// What is known of a generation besides its files.
struct Item {
  Generation generation = 0;
  Generation from = 0;  // the generation before the change
  std::string change{};
  std::string who{};
  std::string why{};
  std::string time{};  // RFC 3339
  Outcome outcome = Outcome::kPending;
  std::string reason{};               // of going back
  std::vector<std::string> others{};  // agents of the other hosts of the change

  bool operator==(const Item&) const = default;
};

enum class State : std::uint8_t { kIdle, kLocked, kApplying, kWaiting, kSettling, kGoingBack };
std::string_view name_of(State state);

// On the disk.
struct Record {
  struct Pending {
    Generation generation = 0;       // of the change
    State state = State::kApplying;  // never kIdle or kLocked
    std::string reason{};            // of going back

    bool operator==(const Pending&) const = default;
  };
  Generation current = 0;  // whose files are in force, also while a change waits
  Generation last = 0;     // the greatest number that was given
  std::optional<Pending> pending{};
  std::vector<Item> items{};  // oldest first, at most kGenerationsKept
  // Other hosts that have not yet heard that this one went back, by change.
  std::map<std::string, std::vector<std::string>> untold{};

  [[nodiscard]] const Item* find(Generation generation) const;
  [[nodiscard]] const Item* find_change(std::string_view change) const;
  bool operator==(const Record&) const = default;
};

// What the shell is to do, one after the other; each is told back by done().
struct Step {
  enum class Kind : std::uint8_t {
    kSave,   // the record to the disk, durably
    kWrite,  // the files of a generation into the configuration folder
    kApply,  // reload and restart what differs between `from` and the generation
  };
  Kind kind = Kind::kSave;
  Generation from = 0;
  Generation generation = 0;

  bool operator==(const Step&) const = default;
};

// How a host stands to a change; what hosts tell each other.
enum class Standing : std::uint8_t { kUnknown, kUnderWay, kConfirmed, kWentBack };
std::string_view name_of(Standing standing);
std::optional<Standing> standing_of(std::string_view name);

struct Refusal {
  std::string code;  // as in PROTOCOL.md: "locked"
  std::string text;
};
using Refused = std::optional<Refusal>;

class HostChange {
 public:
  // As read from the disk. A change that was under way when the agent ended goes back.
  HostChange(tims::Time now, Record record);

  [[nodiscard]] const Record& record() const { return record_; }
  [[nodiscard]] State state(tims::Time now) const;
  [[nodiscard]] const Item* pending() const;                    // null: none
  [[nodiscard]] std::string lock_holder(tims::Time now) const;  // empty: it is not locked
  [[nodiscard]] const std::string& locking_change() const { return lock_; }
  // Until it goes back, or the lock ends.
  [[nodiscard]] tims::Duration left(tims::Time now) const;
  [[nodiscard]] tims::Duration window() const { return window_; }

  // The files were found in another form than those of the current generation: a generation of its
  // own. The caller has stored its files. Only while nothing is under way.
  Generation found(const std::string& time, const std::string& who);
  // The number of the next generation.
  [[nodiscard]] Generation next() const { return record_.last + 1; }

  Refused lock(tims::Time now, const std::string& change, const std::string& who,
               tims::Duration time);
  Refused unlock(tims::Time now, const std::string& change);
  // Whether begin() would be refused.
  [[nodiscard]] Refused may_begin(tims::Time now, const std::string& change) const;
  // The caller has stored the files of generation next(). `item`: change, who, why, time, others.
  Refused begin(tims::Time now, Item item, tims::Duration window);
  Refused confirm(tims::Time now, const std::string& change);
  Refused undo(tims::Time now, const std::string& change, const std::string& reason);

  [[nodiscard]] const Step* step() const { return steps_.empty() ? nullptr : &steps_.front(); }
  void done(tims::Time now);
  // A step failed: the change goes back; when going back fails, it is tried again later.
  void failed(tims::Time now, const std::string& reason);

  // --- other hosts
  struct Peer {
    std::string agent;
    std::string change;
    Standing own = Standing::kUnknown;  // to tell
  };
  // Whom to ask or tell now.
  std::vector<Peer> peers_to_ask(tims::Time now);
  [[nodiscard]] Standing standing(std::string_view change) const;
  // Another host has told how it stands; the answer to it is standing().
  void heard(tims::Time now, const std::string& agent, const std::string& change,
             Standing standing);
  // It has answered, so it has heard how this host stands.
  void answered(tims::Time now, const std::string& agent, const std::string& change,
                Standing standing);

  [[nodiscard]] tims::Time next_timeout() const;
  void on_timeout(tims::Time now);

 private:
  Item& item(Generation generation);
  void save() { steps_.push_back({.kind = Step::Kind::kSave}); }
  void go_back(const std::string& reason);
  void go_back_to(Generation generation, const std::string& reason);
  [[nodiscard]] tims::Time untold_at() const;
  void finish(Outcome outcome);
  void settle_if_all_are(tims::Time now);
  [[nodiscard]] Refused need(const std::string& change) const;
  void forget_old();

  Record record_;
  std::deque<Step> steps_;
  tims::Duration window_ = kWindow;
  tims::Time deadline_ = tims::kNever;
  std::string lock_;  // the change
  std::string lock_holder_;
  tims::Time lock_end_{};
  std::map<std::string, Standing> peers_;
  tims::Time ask_at_ = tims::kNever;
  tims::Duration tell_pause_ = kAskPeers;
};

}  // namespace timsctl::configuration
