// The ways of one link to the other router, in order of preference, and which of them carries what
// we send. The other side chooses for its own direction.
//
// A way works while what is asked over it is answered (CHALLENGE, RESPONSE); the answer may come
// any way, so that a filter in one direction stops that direction only. The way in use is asked
// every keep-alive interval, and more often once an answer is overdue; it is given up after two
// intervals, before the third without a sign of life takes the link itself down. A better one is
// taken back when it has worked for a while.
//
// A link with one way asks nothing: it has no choice.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "router/link/net_address.h"
#include "tims/time.h"

namespace tims::link {

struct PathCounters {
  std::uint64_t datagrams_in = 0;
  std::uint64_t datagrams_out = 0;
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
};

struct Path {
  // So long must a better way have worked before it is used again: twice as long each time that it
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

  // True when the way that was used is none any more.
  bool configure(Time now, std::span<const PathKind> preference, Duration keep_alive);
  void set_targets(PathKind kind, std::span<const NetAddress> targets);
  [[nodiscard]] bool has_targets() const;
  [[nodiscard]] bool is_target(const NetAddress& address) const;
  // Where HELLOs go; `first`: to the preferred way only, if it leads anywhere.
  [[nodiscard]] std::vector<NetAddress> to_call(bool first) const;

  // The other router has answered from there: this way is used from now on.
  void begin(Time now, const NetAddress& address);
  // It is there, as far as we know.
  [[nodiscard]] bool is_at(const NetAddress& address) const;
  // Whether anything may be sent that way: where it is or should be is known.
  [[nodiscard]] bool leads(PathKind kind) const;
  // No other way has led to it so far: whoever is there may be another router.
  [[nodiscard]] bool is_strange(const NetAddress& from) const;
  // The link was silent and is up again: which ways still work is to be seen.
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
  // What we sent then, the way in use, has arrived.
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
  // Why this way is used and since when.
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
