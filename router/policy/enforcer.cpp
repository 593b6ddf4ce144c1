#include "router/policy/enforcer.h"

#include <algorithm>
#include <bit>
#include <string_view>

namespace tims::policy {
namespace {

constexpr std::size_t kStreamSets = 1024;
constexpr unsigned kCellShift = 64 - std::bit_width(Enforcer::kCacheCells - 1);

std::uint64_t mixed(std::uint64_t value) {
  value = (value ^ value >> 32) * 0x9E3779B97F4A7C15ULL;
  value = (value ^ value >> 29) * 0xBF58476D1CE4E5B9ULL;
  return value ^ value >> 32;
}

std::string key_of(const Subject& subject) {
  std::string key = subject.name;
  for (const std::string& identity : subject.identities) key.append("\n").append(identity);
  return key;
}

bool is_same_rule(const RuleText& a, const RuleText& b) {
  RuleText moved = a;
  moved.place = b.place;
  return moved == b;
}

}  // namespace

Enforcer::Enforcer(Policy policy, std::uint64_t secret)
    : policy_(std::move(policy)),
      secret_(secret),
      component_mask_(~0U << policy_.widths().local),
      hits_(policy_.rules().size()),
      conversations_(secret),
      cache_(kCacheCells),
      streams_(kStreamSets) {}

void Enforcer::set(Time now, Policy policy) {
  for (const auto& [key, profile] : profiles_) take_reports(kNever, *profile, left_);
  if (!left_.empty()) next_report_ = now;
  std::vector<Hits> hits(policy.rules().size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const auto same = std::ranges::find_if(policy_.rules(), [&](const Rule& rule) {
      return is_same_rule(rule.text, policy.rules()[i].text);
    });
    if (same != policy_.rules().end())
      hits[i] = hits_[static_cast<std::size_t>(same - policy_.rules().begin())];
  }
  hits_ = std::move(hits);
  policy_ = std::move(policy);
  streams_.assign(kStreamSets, {});
  buckets_.clear();
  for (const auto& [key, profile] : profiles_) build(*profile);
}

Profile& Enforcer::enter(Time now, const Subject& subject) {
  // A bucket that is full again forgets nothing.
  std::erase_if(buckets_, [&](const auto& entry) {
    return entry.second.users == 0 && entry.second.limiter.is_full(now);
  });
  auto& profile = profiles_[key_of(subject)];
  if (!profile) {
    profile = std::make_unique<Profile>();
    profile->subject_ = subject;
    build(*profile);
  }
  ++profile->clients_;
  return *profile;
}

void Enforcer::leave(Time now, Profile& profile) {
  if (--profile.clients_ > 0) return;
  take_reports(kNever, profile, left_);
  if (!left_.empty()) next_report_ = std::min(next_report_, now + kReportEvery);
  for (const RuleNumber number : profile.rules_)
    if (const auto found = buckets_.find({profile.subject_.name, number}); found != buckets_.end())
      --found->second.users;
  profiles_.erase(key_of(profile.subject_));
}

void Enforcer::build(Profile& profile) {
  profile.id_ = ++last_id_;
  profile.salt_ = mixed(secret_ + profile.id_) | 1;
  profile.rules_ = policy_.rules_for(profile.subject_);
  profile.free_ = policy_.rule(profile.rules_.front()).lets_all_pass();
  profile.rulings_.clear();
  for (const RuleNumber number : profile.rules_) {
    const Rule& rule = policy_.rule(number);
    profile.rulings_.push_back(
        {.rule = number, .action = rule.action, .priority_max = rule.text.priority_max});
    if (rule.text.rate == 0) continue;
    const auto [place, added] = buckets_.try_emplace({profile.subject_.name, number});
    if (added) place->second.limiter = {rule.text.rate, rule.text.rate};
    ++place->second.users;
    profile.rulings_.back().bucket = &place->second.limiter;
  }
}

Verdict Enforcer::judge(Time now, Profile& profile, const Query& query, std::uint8_t priority,
                        std::uint32_t bytes) {
  Profile::Ruling& found = ruling(profile, query);
  if (!found.lets_pass(priority)) return judge_by(now, found, query, priority, bytes);
  count(hits_[found.rule], bytes);
  return {.rule = found.rule, .priority = priority, .lasts = true};
}

Verdict Enforcer::judge_by(Time now, Profile::Ruling& ruling, const Query& query,
                           std::uint8_t priority, std::uint32_t bytes) {
  if (ruling.action != Action::kThin && is_answer(now, query)) {
    ++replies_;
    return {.priority = std::min(priority, kReplyPriorityMax)};
  }
  Hits& hits = hits_[ruling.rule];
  count(hits, bytes);
  if (ruling.action == Action::kDeny) return deny(now, ruling, priority);
  if (ruling.bucket != nullptr) {
    if (!ruling.bucket->ready(now)) {
      ++hits.over_rate;
      return deny(now, ruling, priority);
    }
    ruling.bucket->take(bytes);
  }
  if (ruling.action == Action::kThin && !passes_thin(now, ruling.rule, query, bytes)) {
    ++hits.thinned;
    return {.what = Verdict::What::kThinned, .rule = ruling.rule, .priority = priority};
  }
  if (priority > ruling.priority_max) ++hits.lowered;
  return {.rule = ruling.rule,
          .priority = std::min(priority, ruling.priority_max),
          .report = ruling.action == Action::kObserve && is_news(now, ruling)};
}

// Samples keep the conversation open.
bool Enforcer::is_answer(Time now, const Query& query) {
  if (query.type > 0 || query.right != Right::kNone) return false;
  const Address asker = component(query.dest);
  const Address other = component(query.src);
  if (!conversations_.is_open(now, asker, other)) return false;
  if (query.is_sample) conversations_.open(now, asker, other);
  return true;
}

Verdict Enforcer::deny(Time now, Profile::Ruling& ruling, std::uint8_t priority) {
  ++hits_[ruling.rule].denied;
  return {.what = Verdict::What::kDenied,
          .rule = ruling.rule,
          .priority = priority,
          .report = is_news(now, ruling)};
}

bool Enforcer::is_news(Time now, Profile::Ruling& ruling) {
  if (now < ruling.report_at) {
    ++ruling.denied;
    return false;
  }
  ruling.report_at = now + kReportEvery;
  next_report_ = std::min(next_report_, ruling.report_at);
  return true;
}

// Of the deciding rule, from the cache if it is there. All that a decision depends on is in the
// key; a product with an odd secret number spreads it over the cells.
Profile::Ruling& Enforcer::ruling(Profile& profile, const Query& query) {
  const std::uint64_t class_id = query.type > 0 ? 0 : query.class_id(policy_.widths());
  const std::uint64_t kind = (query.is_sample ? 1U : 0U) | static_cast<unsigned>(query.right) << 1U;
  const std::uint64_t key = std::uint64_t{query.dest.raw()} << 32 | class_id << 16 |
                            std::uint64_t{static_cast<std::uint8_t>(query.type)} << 8 | kind;
  Cell& cell = cache_[key * profile.salt_ >> kCellShift];
  if (cell.key != key || cell.profile != profile.id_)
    cell = {.key = key, .profile = profile.id_, .position = decide(profile, query)};
  return profile.rulings_[cell.position];
}

// The place of the deciding rule in the profile.
std::uint32_t Enforcer::decide(const Profile& profile, const Query& query) const {
  const auto found =
      std::ranges::lower_bound(profile.rules_, policy_.decide(profile.rules_, query));
  return static_cast<std::uint32_t>(found - profile.rules_.begin());
}

bool Enforcer::passes_thin(Time now, RuleNumber number, const Query& query, std::uint32_t bytes) {
  const RuleText& rule = policy_.rule(number).text;
  if (rule.bytes_max != 0 && bytes > rule.bytes_max) return false;
  if (rule.every == 0 && rule.per_second == 0) return true;
  Stream& stream = stream_of(number, query);
  stream.last = now;
  const bool is_turn = rule.every == 0 || stream.samples++ % rule.every == 0;
  if (!is_turn) return false;
  if (rule.per_second == 0) return true;
  if (now < stream.next) return false;
  // From where it was due, so that samples that come a little late do not lower the rate.
  const Duration interval = Duration(std::chrono::seconds(1)) / rule.per_second;
  stream.next = std::max(stream.next + interval, now);
  if (stream.next == now) stream.next = now + interval;
  return true;
}

Enforcer::Stream& Enforcer::stream_of(RuleNumber number, const Query& query) {
  const std::uint64_t both = std::uint64_t{query.src.raw()} << 32 | query.dest.raw();
  const auto set_number =
      static_cast<std::size_t>(mixed((both ^ secret_) + number) & (kStreamSets - 1));
  auto& set = streams_[set_number];
  Stream* oldest = set.data();
  for (Stream& stream : set) {
    if (stream.rule == number && stream.src == query.src && stream.dest == query.dest &&
        stream.type == query.type)
      return stream;
    if (stream.last < oldest->last) oldest = &stream;
  }
  *oldest = {.src = query.src, .dest = query.dest, .rule = number, .type = query.type};
  return *oldest;
}

std::vector<DenialReport> Enforcer::take_reports(Time now) {
  std::vector<DenialReport> reports = std::exchange(left_, {});
  next_report_ = kNever;
  for (const auto& [key, profile] : profiles_) take_reports(now, *profile, reports);
  return reports;
}

void Enforcer::take_reports(Time now, Profile& profile, std::vector<DenialReport>& reports) {
  for (Profile::Ruling& ruling : profile.rulings_) {
    if (ruling.denied == 0) continue;
    if (now < ruling.report_at) {
      next_report_ = std::min(next_report_, ruling.report_at);
      continue;
    }
    const RuleText& rule = policy_.rule(ruling.rule).text;
    reports.push_back(
        {rule.name, rule.place, profile.subject_.name, std::exchange(ruling.denied, 0)});
    // The next minute is counted, too.
    ruling.report_at = now == kNever ? Time{} : now + kReportEvery;
  }
}

}  // namespace tims::policy
