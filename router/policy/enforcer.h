// Applies the policy to messages, where they enter the fleet: verdicts, their cache, rates, thinned
// streams, counters of hits, and what is to be reported about denials.
//
// A client is judged by the Profile of its subject: the rules that can apply to it, found once when
// it connects. Judging a message allocates nothing. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/rate_limiter.h"
#include "router/policy/conversations.h"
#include "router/policy/policy.h"
#include "router/policy/subject.h"
#include "tims/time.h"

namespace tims::policy {

// The rules of a subject, and what its connections share.
class Profile {
 public:
  // True when everything passes: its messages are not judged, and a local program may write to
  // mailboxes directly.
  [[nodiscard]] bool is_free() const { return free_; }
  [[nodiscard]] const Subject& subject() const { return subject_; }
  [[nodiscard]] const std::vector<RuleNumber>& rules() const { return rules_; }

 private:
  friend class Enforcer;
  struct State {                          // of one of its rules
    base::RateLimiter* bucket = nullptr;  // null: no rate
    std::uint64_t denied = 0;             // not reported yet
    Time report_at{};                     // before: a denial is only counted
  };

  Subject subject_;
  std::uint32_t id_ = 0;  // never used again, so that old verdicts in the cache are never found
  bool free_ = false;
  std::vector<RuleNumber> rules_;
  std::vector<State> states_;
  std::size_t clients_ = 0;
};

struct Hits {
  std::uint64_t messages = 0;  // that matched, whatever became of them
  std::uint64_t bytes = 0;
  std::uint64_t denied = 0;     // by the rule, or above its rate
  std::uint64_t over_rate = 0;  // of these
  std::uint64_t lowered = 0;    // to its priority
  std::uint64_t thinned = 0;    // samples that were not passed on
};

struct Verdict {
  enum class What : std::uint8_t { kPass, kDenied, kThinned };
  What what = What::kPass;
  RuleNumber rule = 0;        // kDenied, kThinned, and passing ones with `report`
  std::uint8_t priority = 0;  // the message's from now on
  bool report = false;  // the first denial (or observation) of this rule and subject in a minute
};

// Denials that were only counted since the last report.
struct DenialReport {
  std::string rule;
  std::string place;
  std::string subject;
  std::uint64_t messages = 0;
};

class Enforcer {
 public:
  static constexpr Duration kReportEvery = std::chrono::seconds(60);
  // The highest priority of an answer that needs no rule: above it are commands that stop.
  static constexpr std::uint8_t kReplyPriorityMax = 99;
  static constexpr std::size_t kCacheCells = 32'768;

  // `secret`: unpredictable, for the tables.
  Enforcer(Policy policy, std::uint64_t secret);

  // Rules that did not change keep their counters.
  void set(Time now, Policy policy);
  [[nodiscard]] const Policy& policy() const { return policy_; }
  [[nodiscard]] const Hits& hits(RuleNumber rule) const { return hits_[rule]; }
  // Answers that passed without a rule.
  [[nodiscard]] std::uint64_t replies() const { return replies_; }

  // A client connects; its profile stays valid until leave().
  Profile& enter(Time now, const Subject& subject);
  void leave(Time now, Profile& profile);
  template <typename Visit>  // (const Profile&, number of clients)
  void for_each(Visit visit) const {
    for (const auto& [key, profile] : profiles_) visit(*profile, profile->clients_);
  }

  // Precondition: the profile is not free. `bytes`: of the message, with its header.
  Verdict judge(Time now, Profile& profile, const Query& query, std::uint8_t priority,
                std::uint32_t bytes);
  // A command of `asker` is delivered to a client that is not free, or a sample of a stream that
  // was asked for to `asker`: answers of `other` need no rule for a minute (Query::is_answer).
  void asked(Time now, Address asker, Address other) { conversations_.open(now, asker, other); }
  [[nodiscard]] bool is_answer(Time now, Address asker, Address other) const {
    return conversations_.is_open(now, asker, other);
  }

  // Counts that are due; call at or after next_report().
  std::vector<DenialReport> take_reports(Time now);
  [[nodiscard]] Time next_report() const { return next_report_; }

 private:
  struct Cell {
    std::uint32_t profile = 0;  // 0: empty
    std::uint32_t dest = 0;
    std::uint16_t class_id = 0;
    std::uint8_t type = 0;
    std::uint8_t kind = 0;  // sample, right
    std::uint16_t position = 0;
    std::uint16_t spare = 0;
  };
  static_assert(sizeof(Cell) == 16);
  struct Bucket {
    base::RateLimiter limiter;
    std::size_t users = 0;
  };
  struct Stream {
    Address src{};
    Address dest{};
    RuleNumber rule = 0;
    std::int8_t type = 0;
    std::uint32_t samples = 0;
    Time next{};  // the earliest time of the next sample
    Time last{};
  };

  void build(Profile& profile);
  [[nodiscard]] std::uint16_t position(const Profile& profile, const Query& query);
  [[nodiscard]] bool passes_thin(Time now, RuleNumber number, const Query& query,
                                 std::uint32_t bytes);
  Stream& stream_of(RuleNumber number, const Query& query);
  Verdict deny(Time now, Profile::State& state, RuleNumber rule, std::uint8_t priority);
  bool is_news(Time now, Profile::State& state);
  void take_reports(Time now, Profile& profile, std::vector<DenialReport>& reports);

  Policy policy_;
  std::uint64_t secret_;
  std::vector<Hits> hits_;
  std::uint64_t replies_ = 0;
  std::map<std::string, std::unique_ptr<Profile>, std::less<>> profiles_;  // by identities
  std::map<std::pair<std::string, RuleNumber>, Bucket> buckets_;           // by name of the subject
  std::uint32_t last_id_ = 0;
  Conversations conversations_;
  std::vector<Cell> cache_;
  std::vector<std::array<Stream, 4>> streams_;
  std::vector<DenialReport> left_;  // of profiles that have gone
  Time next_report_ = kNever;
};

}  // namespace tims::policy
