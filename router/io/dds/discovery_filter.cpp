#include "router/io/dds/discovery_filter.h"

#include <utility>

#include "router/io/dds/rtps_message.h"

namespace tims::io {
namespace {

// The library judges those whom it knows; it may hear of them on other ways than we.
constexpr int kLeasesAdmitted = 3;

}  // namespace

DiscoveryFilter::Verdict DiscoveryFilter::on_message(Time now, std::span<const std::byte> bytes,
                                                     bool multicast) {
  const auto message = parse_rtps(bytes);
  if (!message || message->from == own_) return {};
  const auto known = routers_.find(message->from);
  const bool is_known = known != routers_.end();
  if (is_known && known->second.admitted) {
    known->second.heard = now;
    return {.passes = true};
  }
  Verdict verdict;
  if (message->ends) {
    if (is_known) verdict.gone = message->from;
    routers_.erase(message->from);
  } else if (message->announced) {
    auto announcement = link::decode_announcement(message->announced->user_data);
    if (!announcement || announcement->fleet != self_.fleet ||
        announcement->who.epoch == self_.who.epoch)
      return verdict;
    announcement->dds = link::NetAddress::dds(message->from);
    on_announced(now, message->from, bytes, *announcement, message->announced->lease, verdict);
    // Those that look for a router like us hear of us at once, and who does not know our addresses
    // by multicast. What is for us alone is an answer already.
    const bool wants_answer = !multicast || link::is_above(self_.who, announcement->who);
    if (own_message_.empty()) {
      // We have nobody to announce ourselves to: the library answers those whom it discovers.
      if (!multicast) verdict.passes = !admit(message->from).empty();
    } else if (wants_answer && !message->to) {
      verdict.answer = directed(own_message_, message->from);
      verdict.to = message->announced->metatraffic;
    }
  } else if (is_known && own_ && message->to == own_ && budget_.ready(now)) {
    budget_.take(1);
    verdict = {.passes = true, .first = admit(message->from)};
  }
  return verdict;
}

void DiscoveryFilter::on_announced(Time now, const link::DdsParticipant& from,
                                   std::span<const std::byte> message,
                                   const link::Announcement& announcement, Duration lease,
                                   Verdict& verdict) {
  auto known = routers_.find(from);
  if (known == routers_.end()) {
    if (routers_.size() == kRoutersMax || message.size() > kAnnouncedMax) return;
    known = routers_.emplace(from, Router()).first;
  }
  Router& router = known->second;
  router.heard = now;
  router.lease = lease;
  if (router.announcement == announcement) return;
  router.announcement = announcement;
  router.message.assign(message.begin(), message.end());
  verdict.announced = announcement;
}

void DiscoveryFilter::on_own(std::span<const std::byte> bytes) {
  if (own_ && !own_message_.empty()) return;
  const auto message = parse_rtps(bytes);
  if (!message) return;
  own_ = message->from;
  if (message->announced && bytes.size() <= kAnnouncedMax)
    own_message_.assign(bytes.begin(), bytes.end());
}

std::vector<std::byte> DiscoveryFilter::admit(const link::DdsParticipant& who) {
  const auto known = routers_.find(who);
  if (known == routers_.end() || std::exchange(known->second.admitted, true)) return {};
  return std::exchange(known->second.message, {});
}

std::vector<link::DdsParticipant> DiscoveryFilter::expire(Time now) {
  std::vector<link::DdsParticipant> gone;
  for (const auto& [who, router] : routers_) {
    if (now >= router.heard + (router.admitted ? kLeasesAdmitted : 1) * router.lease)
      gone.push_back(who);
  }
  for (const link::DdsParticipant& who : gone) forget(who);
  return gone;
}

}  // namespace tims::io
