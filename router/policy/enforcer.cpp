#include "router/policy/enforcer.h"

#include <algorithm>
#include <string_view>

namespace tims::policy {
namespace {

constexpr std::size_t kStreamSets = 1024;

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
  profile.rules_ = policy_.rules_for(profile.subject_);
  profile.free_ = policy_.rule(profile.rules_.front()).lets_all_pass();
  profile.states_.assign(profile.rules_.size(), {});
  for (std::size_t i = 0; i < profile.rules_.size(); ++i) {
    const RuleNumber number = profile.rules_[i];
    const std::uint64_t rate = policy_.rule(number).text.rate;
    if (rate == 0) continue;
    const auto [place, added] = buckets_.try_emplace({profile.subject_.name, number});
    if (added) place->second.limiter = {rate, rate};
    ++place->second.users;
    profile.states_[i].bucket = &place->second.limiter;
  }
}

Verdict Enforcer::judge(Time now, Profile& profile, const Query& query, std::uint8_t priority,
                        std::uint32_t bytes) {
  const std::uint16_t at = position(profile, query);
  const RuleNumber number = profile.rules_[at];
  const Rule& rule = policy_.rule(number);
  if (rule.action != Action::kThin && query.is_answer) {
    ++replies_;
    return {.priority = std::min(priority, kReplyPriorityMax)};
  }
  Hits& hits = hits_[number];
  ++hits.messages;
  hits.bytes += bytes;
  Profile::State& state = profile.states_[at];
  if (rule.action == Action::kDeny) return deny(now, state, number, priority);
  if (state.bucket != nullptr) {
    if (!state.bucket->ready(now)) {
      ++hits.over_rate;
      return deny(now, state, number, priority);
    }
    state.bucket->take(bytes);
  }
  if (rule.action == Action::kThin && !passes_thin(now, number, query, bytes)) {
    ++hits.thinned;
    return {.what = Verdict::What::kThinned, .rule = number, .priority = priority};
  }
  if (priority > rule.text.priority_max) ++hits.lowered;
  return {.rule = number,
          .priority = std::min(priority, rule.text.priority_max),
          .report = rule.action == Action::kObserve && is_news(now, state)};
}

Verdict Enforcer::deny(Time now, Profile::State& state, RuleNumber rule, std::uint8_t priority) {
  ++hits_[rule].denied;
  return {.what = Verdict::What::kDenied,
          .rule = rule,
          .priority = priority,
          .report = is_news(now, state)};
}

bool Enforcer::is_news(Time now, Profile::State& state) {
  if (now < state.report_at) {
    ++state.denied;
    return false;
  }
  state.report_at = now + kReportEvery;
  next_report_ = std::min(next_report_, state.report_at);
  return true;
}

// The place of the deciding rule in the profile, from the cache if it is there.
std::uint16_t Enforcer::position(const Profile& profile, const Query& query) {
  const std::uint16_t class_id = query.class_id(policy_.widths());
  const auto type = static_cast<std::uint8_t>(query.type);
  const auto kind = static_cast<std::uint8_t>((query.is_sample ? 1U : 0U) |
                                              static_cast<unsigned>(query.right) << 1U);
  const std::uint64_t word = std::uint64_t{query.dest.raw()} << 32 | std::uint64_t{class_id} << 16 |
                             std::uint64_t{type} << 8 | kind;
  const std::size_t number = mixed((word ^ secret_) + mixed(profile.id_)) & (kCacheCells - 1);
  Cell& cell = cache_[number];
  if (cell.profile == profile.id_ && cell.dest == query.dest.raw() && cell.class_id == class_id &&
      cell.type == type && cell.kind == kind)
    return cell.position;
  const RuleNumber decided = policy_.decide(profile.rules_, query);
  const auto found = std::ranges::lower_bound(profile.rules_, decided);
  const auto at = static_cast<std::uint16_t>(found - profile.rules_.begin());
  cell = {.profile = profile.id_,
          .dest = query.dest.raw(),
          .class_id = class_id,
          .type = type,
          .kind = kind,
          .position = at};
  return at;
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
  const std::uint64_t set_number = mixed((both ^ secret_) + number) & (kStreamSets - 1);
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
  for (std::size_t i = 0; i < profile.states_.size(); ++i) {
    Profile::State& state = profile.states_[i];
    if (state.denied == 0) continue;
    if (now < state.report_at) {
      next_report_ = std::min(next_report_, state.report_at);
      continue;
    }
    const RuleText& rule = policy_.rule(profile.rules_[i]).text;
    reports.push_back(
        {rule.name, rule.place, profile.subject_.name, std::exchange(state.denied, 0)});
    // The next minute is counted, too.
    state.report_at = now == kNever ? Time{} : now + kReportEvery;
  }
}

}  // namespace tims::policy
