// The paths of one link to the other router, in order of preference, the choice of the path for
// our datagrams, and the datagram size on it. The other side chooses for its own direction.
//
// A path works while challenges sent over it are answered (CHALLENGE, RESPONSE); the answer may
// arrive over any path, so a filter in one direction disables only that direction. The path in
// use is challenged every keep-alive interval, and more often once an answer is overdue; it is
// given up after two intervals, before the third interval without a reply takes the link itself
// down. A preferred path is used again after it has worked for a while.
//
// A link with one path sends no challenges, since it has no choice.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "router/link/datagram.h"
#include "router/link/transport.h"
#include "tims/time.h"

namespace tims::link {

// Size of datagrams: found by sending larger ones and checking whether they arrive, without help
// from routers on the path (DPLPMTUD, RFC 8899). It begins at 1200 bytes. When larger datagrams
// are lost repeatedly while smaller ones arrive, the path has changed, and the search restarts at
// 1200; when those are lost too, as in some tunnels, it restarts at 548.
class PathMtu {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }

  // The size to probe now with a datagram of its own, not above `most`; 0: none.
  [[nodiscard]] std::size_t probe(Time now, std::size_t most) const;
  [[nodiscard]] Time next_probe(std::size_t most) const {
    const bool tries = !probing_ && step_ < kSteps.size() && kSteps[step_] <= most;
    return tries ? next_ : kNever;
  }
  void on_probe_sent(std::size_t size);
  void on_probe_acked(Time now, std::size_t size);
  void on_probe_lost(Time now);

  // Called for ordinary datagrams, with the time when they were sent; on_lost() returns true when
  // the size was reduced.
  void on_acked(std::size_t datagram, Time sent);
  bool on_lost(Time now, std::size_t datagram, Time sent);
  void reset(Time now);  // called for a new path
  // For a path that takes any datagram up to this size and none larger: nothing is probed.
  void fix(std::size_t size);

 private:
  // Tunnels in tunnels; Ethernet minus IPv6 and UDP, and minus IPv4 and UDP; sizes of overlay
  // networks; jumbo frames.
  static constexpr std::array<std::size_t, 12> kSteps{
      800, 968, 1064, 1136, kDatagramBase, 1372, 1432, 1452, 1472, 4052, 8952, kDatagramMax};
  static constexpr std::size_t kFirstStep = 5;  // the first above kDatagramBase
  static constexpr int kTries = 3;
  static constexpr int kBlackHole = 6;  // consecutive losses of large datagrams
  static constexpr Duration kTryAgain = std::chrono::minutes(5);
  // Below kDatagramBase, where a short outage may be the reason; doubled each time.
  static constexpr Duration kTrySmallAgain = std::chrono::seconds(10);
  static constexpr Duration kBetween = std::chrono::milliseconds(20);

  // The size that the path has carried, or the one assumed.
  [[nodiscard]] std::size_t floor() const {
    return size_ > kDatagramBase ? kDatagramBase : kDatagramMin;
  }
  void restart(Time now, std::size_t size);

  std::size_t size_ = kDatagramBase;
  std::size_t step_ = kFirstStep;  // index in kSteps of the next size to try
  bool fixed_ = false;
  bool probing_ = false;
  int tries_ = 0;
  int lost_in_a_row_ = 0;
  // Losses of datagrams that were sent before do not count: a large one has arrived since, or the
  // search has restarted.
  Time counts_since_{};
  Duration try_small_again_ = kTrySmallAgain;
  Time next_{};
};

struct PathCounters {
  std::uint64_t datagrams_in = 0;
  std::uint64_t datagrams_out = 0;
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
};

struct Path {
  // How long a preferred path must work before it is used again: doubled each time it fails again
  // within a minute, so that an unstable path is avoided.
  static constexpr Duration kProbation = std::chrono::seconds(3);
  static constexpr Duration kProbationMax = std::chrono::minutes(1);

  PathKind kind = PathKind::kUdp;
  std::vector<NetAddress> targets{};  // possible addresses of the other router
  NetAddress address{};               // its current address, as far as known
  bool works = false;
  Time since{};     // start of the current state (working or not)
  Time answered{};  // time of the newest answer
  Time asked{};     // time of the newest challenge
  Time failed{};    // when it was given up while in use
  Duration probation = kProbation;
  PathCounters counters{};

  [[nodiscard]] bool is_target(const NetAddress& where) const;
};

class Paths {
 public:
  // Challenge interval for paths not in use, unless the keep-alive interval is longer.
  static constexpr Duration kStandbyEvery = std::chrono::seconds(1);

  // Returns true when the path in use has been removed.
  bool configure(Time now, std::span<const PathKind> preference, Duration keep_alive);
  void set_targets(PathKind kind, std::span<const NetAddress> targets);
  [[nodiscard]] bool has_targets() const;
  [[nodiscard]] bool is_target(const NetAddress& address) const;
  // Addresses for HELLO; `first`: only those of the preferred path, if it has any.
  [[nodiscard]] std::vector<NetAddress> to_call(bool first) const;

  // The other router has answered from this address: this path is used from now on.
  void begin(Time now, const NetAddress& address);
  // True when the other router is at this address, as far as known.
  [[nodiscard]] bool is_at(const NetAddress& address) const;
  // True when datagrams can be sent over it: an actual or possible address is known.
  [[nodiscard]] bool leads(PathKind kind) const;
  // True when no other path has led to this address: the sender may be another router.
  [[nodiscard]] bool is_strange(const NetAddress& from) const;
  // The other router calls from this address to go on with the session: there it can be reached,
  // which `proven` says has been verified. Returns true when the path in use has changed.
  bool on_called(Time now, const NetAddress& from, bool proven);
  // The link was silent and is up again: all paths must be checked.
  void begin_again(Time now);

  // The destination of our datagrams; no address before begin().
  [[nodiscard]] const NetAddress& address() const { return used().address; }
  [[nodiscard]] PathKind kind() const { return used().kind; }

  // --- challenges
  struct Question {
    NetAddress to{};
    std::uint64_t nonce = 0;
  };
  // A datagram of the other router came from this address. Returns a challenge if it may have
  // moved there.
  std::optional<Question> on_source(Time now, const NetAddress& from, std::uint64_t random);
  // Calls `ask` for each challenge that is due.
  template <typename Random, typename Ask>
  void ask(Time now, Duration rtt, Random random, Ask ask) {
    if (!several()) return;
    for (Path& path : paths_) {
      if (now < next_question(path, rtt)) continue;
      path.asked = now;
      for (const NetAddress& to : places(path)) ask(note({to, random()}, true));
    }
  }
  // Returns true when the path in use has changed.
  bool on_answer(Time now, const NetAddress& from, std::uint64_t nonce);
  // The other router is no longer at this address. Returns as on_answer().
  bool on_gone(Time now, const NetAddress& where);
  // A packet sent at this time over the path in use has arrived.
  void on_arrived(Time sent) {
    if (sent >= since_ && sent > used().answered) used().answered = sent;
  }

  // --- time
  [[nodiscard]] Time next_timeout(Duration rtt) const;
  bool on_timeout(Time now, Duration rtt);  // returns as on_answer()

  // --- read access
  [[nodiscard]] std::span<const Path> all() const { return paths_; }
  [[nodiscard]] const Path* find(PathKind kind) const;
  [[nodiscard]] bool uses(PathKind kind) const { return find(kind) != nullptr; }
  void count_in(PathKind kind, std::size_t bytes);
  void count_out(PathKind kind, std::size_t bytes);
  // Why this path is used and since when.
  [[nodiscard]] const std::string& why() const { return why_; }
  [[nodiscard]] Time since() const { return since_; }
  [[nodiscard]] bool several() const { return paths_.size() > 1; }

 private:
  struct Asked {
    Question question{};
    // A configured or announced address; otherwise known only as the source of a datagram.
    bool known = false;
  };
  [[nodiscard]] Path* mine(PathKind kind);
  [[nodiscard]] Path& used() { return paths_[used_]; }
  [[nodiscard]] const Path& used() const { return paths_[used_]; }
  Question note(const Question& question, bool known);
  [[nodiscard]] static std::vector<NetAddress> places(const Path& path);
  [[nodiscard]] Duration interval(const Path& path) const;
  [[nodiscard]] Time alive_at(const Path& path) const;
  [[nodiscard]] Time next_question(const Path& path, Duration rtt) const;
  [[nodiscard]] Time dead_at(const Path& path, Duration rtt) const;
  void fail(Time now, Path& path);
  bool choose(Time now);
  void use(Time now, std::size_t index, std::string why);

  std::vector<Path> paths_{Path{}};  // never empty
  std::size_t used_ = 0;
  Duration keep_alive_{};
  std::string why_{};
  Time since_{};
  std::array<Asked, 32> asked_{};
  std::size_t next_asked_ = 0;
  NetAddress suspected_{};  // from the newest on_source()
  Time suspected_at_{};
};

}  // namespace tims::link
