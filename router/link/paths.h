// The paths of one link to the other router, in order of preference, and which of them carries what
// we send; and how large datagrams may be on it. The other side chooses for its own direction.
//
// A path works while what is asked over it is answered (CHALLENGE, RESPONSE); the answer may come
// over any path, so that a filter in one direction stops that direction only. The path in use is
// asked every keep-alive interval, and more often once an answer is overdue; it is given up after
// two intervals, before the third without a sign of life takes the link itself down. A better one
// is taken back when it has worked for a while.
//
// A link with one path asks nothing: it has no choice.
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

// How large datagrams may be: found by sending larger ones and seeing whether they arrive, without
// any help from routers on the way (DPLPMTUD, RFC 8899). 1200 bytes always pass. When datagrams
// larger than that keep being lost, the path has changed, and it begins again at 1200.
class PathMtu {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }

  // The size to try now, as a datagram of its own and not above `most`; 0: none.
  [[nodiscard]] std::size_t probe(Time now, std::size_t most) const;
  [[nodiscard]] Time next_probe(std::size_t most) const {
    const bool tries = !probing_ && step_ < kSteps.size() && kSteps[step_] <= most;
    return tries ? next_ : kNever;
  }
  void on_probe_sent(std::size_t size);
  void on_probe_acked(Time now, std::size_t size);
  void on_probe_lost(Time now);

  // An ordinary datagram. True when the size was reduced.
  void on_acked(std::size_t datagram);
  bool on_lost(Time now, std::size_t datagram);
  void reset(Time now);  // another path
  // One that takes any datagram up to this, and none larger: nothing is tried.
  void fix(std::size_t size);

 private:
  // Ethernet less IPv6 and UDP, less IPv4 and UDP; steps of overlays; jumbo frames.
  static constexpr std::array<std::size_t, 7> kSteps{1372, 1432, 1452,        1472,
                                                     4052, 8952, kDatagramMax};
  static constexpr int kTries = 3;
  static constexpr int kBlackHole = 6;  // large ones lost in a row
  static constexpr Duration kTryAgain = std::chrono::minutes(5);
  static constexpr Duration kBetween = std::chrono::milliseconds(20);

  std::size_t size_ = kDatagramBase;
  std::size_t step_ = 0;  // of kSteps, to be tried next
  bool fixed_ = false;
  bool probing_ = false;
  int tries_ = 0;
  int lost_in_a_row_ = 0;
  Time next_{};
};

struct PathCounters {
  std::uint64_t datagrams_in = 0;
  std::uint64_t datagrams_out = 0;
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
};

struct Path {
  // So long must a better path have worked before it is used again: twice as long each time that it
  // fails again within a minute, so that one that comes and goes is left alone.
  static constexpr Duration kProbation = std::chrono::seconds(3);
  static constexpr Duration kProbationMax = std::chrono::minutes(1);

  PathKind kind = PathKind::kUdp;
  std::vector<NetAddress> targets{};  // where the other router should be
  NetAddress address{};               // where it is, as far as we know
  bool works = false;
  Time since{};     // it works, or does not
  Time answered{};  // the newest answer
  Time asked{};     // the newest question
  Time failed{};    // it was given up while it was used
  Duration probation = kProbation;
  PathCounters counters{};

  [[nodiscard]] bool is_target(const NetAddress& where) const;
};

class Paths {
 public:
  // What is not in use is asked so often, or every keep-alive interval if that is longer.
  static constexpr Duration kStandbyEvery = std::chrono::seconds(1);

  // True when the path that was used is none any more.
  bool configure(Time now, std::span<const PathKind> preference, Duration keep_alive);
  void set_targets(PathKind kind, std::span<const NetAddress> targets);
  [[nodiscard]] bool has_targets() const;
  [[nodiscard]] bool is_target(const NetAddress& address) const;
  // Where HELLOs go; `first`: to the preferred path only, if it leads anywhere.
  [[nodiscard]] std::vector<NetAddress> to_call(bool first) const;

  // The other router has answered from there: this path is used from now on.
  void begin(Time now, const NetAddress& address);
  // It is there, as far as we know.
  [[nodiscard]] bool is_at(const NetAddress& address) const;
  // Whether anything may be sent over it: where it is or should be is known.
  [[nodiscard]] bool leads(PathKind kind) const;
  // No other path has led to it so far: whoever is there may be another router.
  [[nodiscard]] bool is_strange(const NetAddress& from) const;
  // The link was silent and is up again: which paths still work is to be seen.
  void begin_again(Time now);

  // Where to send; no address before begin().
  [[nodiscard]] const NetAddress& address() const { return used().address; }
  [[nodiscard]] PathKind kind() const { return used().kind; }

  // --- questions
  struct Question {
    NetAddress to{};
    std::uint64_t nonce = 0;
  };
  // A datagram of the other router's came from there: is it there now? A question, if so.
  std::optional<Question> on_source(Time now, const NetAddress& from, std::uint64_t random);
  // What is to be asked now.
  template <typename Random, typename Ask>
  void ask(Time now, Duration rtt, Random random, Ask ask) {
    if (!several()) return;
    for (Path& path : paths_) {
      if (now < next_question(path, rtt)) continue;
      path.asked = now;
      for (const NetAddress& to : places(path)) ask(note({to, random()}, true));
    }
  }
  // True when datagrams go elsewhere from now on.
  bool on_answer(Time now, const NetAddress& from, std::uint64_t nonce);
  // Nobody is there any more. As on_answer().
  bool on_gone(Time now, const NetAddress& where);
  // What we sent then, over the path in use, has arrived.
  void on_arrived(Time sent) {
    if (sent >= since_ && sent > used().answered) used().answered = sent;
  }

  // --- time
  [[nodiscard]] Time next_timeout(Duration rtt) const;
  bool on_timeout(Time now, Duration rtt);  // as on_answer()

  // --- to look at
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
    bool known = false;  // an address of ours; else one that only a datagram's source told
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
  NetAddress suspected_{};  // the newest on_source()
  Time suspected_at_{};
};

}  // namespace tims::link
