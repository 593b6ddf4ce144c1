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
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/rate_limiter.h"
#include "router/policy/conversations.h"
#include "router/policy/policy.h"
#include "router/policy/subject.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::policy {

// The rules of a subject, and what its connections share.
class Profile {
 public:
  // True when everything passes: its messages are not judged, and a local program may write to
  // mailboxes directly.
  [[nodiscard]] bool is_free() const { return free_; }
  [[nodiscard]] std::uint32_t id() const { return id_; }  // another one after each reload
  [[nodiscard]] const Subject& subject() const { return subject_; }
  [[nodiscard]] const std::vector<RuleNumber>& rules() const { return rules_; }

 private:
  friend class Enforcer;
  // What one of its rules does, all in one place of memory.
  struct Ruling {
    RuleNumber rule = 0;
    Action action = Action::kDeny;
    std::uint8_t priority_max = 255;
    base::RateLimiter* bucket = nullptr;  // null: no rate
    std::uint64_t denied = 0;             // not reported yet
    Time report_at{};                     // before: a denial is only counted

    // A message of this priority passes as it is, whatever passed before it.
    [[nodiscard]] bool lets_pass(std::uint8_t priority) const {
      return action == Action::kAllow && bucket == nullptr && priority <= priority_max;
    }
  };

  std::uint32_t id_ = 0;  // never used again, so that old verdicts are never found
  bool free_ = false;
  std::uint64_t salt_ = 1;       // of its keys in the cache; odd
  std::vector<Ruling> rulings_;  // of rules_
  std::vector<RuleNumber> rules_;
  Subject subject_;
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
  bool lasts = false;   // the same message passes again, until the rules change
};

// What a client has sent lately and may send again without being judged: most messages are the
// next one of a few streams.
class RecentPasses {
 public:
  // The rule by which the same message has passed; empty: it is to be judged.
  [[nodiscard]] std::optional<RuleNumber> find(const Profile& profile, const Header& header) const;
  // Precondition: the verdict on this message lasts.
  void keep(const Profile& profile, const Header& header, const Verdict& verdict);

 private:
  // Two numbers, so that two comparisons are enough for each message.
  struct Pass {
    std::uint64_t endpoints = 0;
    std::uint64_t kind = 0;  // 0: none
    RuleNumber rule = 0;
  };
  static constexpr unsigned kBits = 3;

  static std::size_t place(Address dest) { return dest.raw() * 0x9E3779B1U >> (32 - kBits); }
  static std::uint64_t endpoints(const Header& header) {
    return std::uint64_t{header.dest.raw()} << 32 | header.src.raw();
  }
  // Of a profile, whose number is never 0.
  static std::uint64_t kind(const Profile& profile, const Header& header) {
    return std::uint64_t{profile.id()} << 32 | std::uint64_t{header.flags} << 16 |
           std::uint64_t{static_cast<std::uint8_t>(header.type)} << 8 | header.priority;
  }

  std::array<Pass, 1U << kBits> passes_{};
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
  // Whether such a message has passed before; then it is counted.
  bool passes_again(const Profile& profile, const RecentPasses& recent, const Header& header,
                    std::uint32_t bytes) {
    const auto rule = recent.find(profile, header);
    if (rule) count(hits_[*rule], bytes);
    return rule.has_value();
  }
  // A command of `asker` is delivered to a client that is not free: what `other` answers needs no
  // rule for a minute, and streams as long as they last. Any of its mailboxes may answer to any of
  // the asker's.
  void asked(Time now, Address asker, Address other) {
    conversations_.open(now, component(asker), component(other));
  }

  // Counts that are due; call at or after next_report().
  std::vector<DenialReport> take_reports(Time now);
  [[nodiscard]] Time next_report() const { return next_report_; }

 private:
  struct Cell {
    std::uint64_t key = 0;
    std::uint32_t profile = 0;  // 0: empty
    std::uint32_t position = 0;
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
  static void count(Hits& hits, std::uint32_t bytes) {
    ++hits.messages;
    hits.bytes += bytes;
  }
  [[nodiscard]] Profile::Ruling& ruling(Profile& profile, const Query& query);
  [[nodiscard]] std::uint32_t decide(const Profile& profile, const Query& query) const;
  Verdict judge_by(Time now, Profile::Ruling& ruling, const Query& query, std::uint8_t priority,
                   std::uint32_t bytes);
  bool is_answer(Time now, const Query& query);
  [[nodiscard]] Address component(Address address) const {
    return Address(address.raw() & component_mask_);
  }
  [[nodiscard]] bool passes_thin(Time now, RuleNumber number, const Query& query,
                                 std::uint32_t bytes);
  Stream& stream_of(RuleNumber number, const Query& query);
  Verdict deny(Time now, Profile::Ruling& ruling, std::uint8_t priority);
  bool is_news(Time now, Profile::Ruling& ruling);
  void take_reports(Time now, Profile& profile, std::vector<DenialReport>& reports);

  Policy policy_;
  std::uint64_t secret_;
  std::uint32_t component_mask_;  // all but the local id
  std::vector<Hits> hits_;
  std::uint64_t replies_ = 0;  // that passed without a rule
  std::map<std::string, std::unique_ptr<Profile>, std::less<>> profiles_;  // by identities
  std::map<std::pair<std::string, RuleNumber>, Bucket> buckets_;           // by name of the subject
  std::uint32_t last_id_ = 0;
  Conversations conversations_;
  std::vector<Cell> cache_;
  std::vector<std::array<Stream, 4>> streams_;
  std::vector<DenialReport> left_;  // of profiles that have gone
  Time next_report_ = kNever;
};

inline std::optional<RuleNumber> RecentPasses::find(const Profile& profile,
                                                    const Header& header) const {
  const Pass& pass = passes_[place(header.dest)];
  const bool same = pass.endpoints == endpoints(header) && pass.kind == kind(profile, header);
  return same ? std::optional(pass.rule) : std::nullopt;
}

inline void RecentPasses::keep(const Profile& profile, const Header& header,
                               const Verdict& verdict) {
  passes_[place(header.dest)] = {
      .endpoints = endpoints(header), .kind = kind(profile, header), .rule = verdict.rule};
}

}  // namespace tims::policy
