// Links, the part that chooses the super router.
#include <utility>

#include "router/link/links.h"

namespace tims::link {
namespace {

// A more preferred super router must have been up for so long before it is used again.
constexpr Duration kFailBackAfter = std::chrono::milliseconds(500);
// So long the one used before still knows what is below us: what is on its way finds us.
constexpr Duration kOverlap = std::chrono::seconds(1);

}  // namespace

void Links::choose_uplink(Time now) {
  if (!std::exchange(choose_, false)) return;
  Link* best = nullptr;
  for (const std::uint32_t slot : supers_) {
    Link& link = *links_[slot];
    const bool settled = now >= link.since() + kFailBackAfter || uplink_ == nullptr ||
                         !uplink_->is_up() || &link == uplink_;
    if (!link.is_up() || !settled) continue;
    best = &link;
    break;
  }
  if (best != uplink_) {
    uplink_before_ = std::exchange(uplink_, best);
    overlap_end_ = now + kOverlap;
  }
  router_.set_uplink(now, best == nullptr ? core::kNoClient : best->client());
  using Telling = Exchange::Telling;
  for (const std::uint32_t slot : supers_) {
    Link& link = *links_[slot];
    const bool leaving = &link == uplink_before_ && now < overlap_end_;
    link.set_telling(now, &link == best ? Telling::kAll
                          : leaving     ? Telling::kAsFarther
                                        : Telling::kNothing);
    touch(link);
  }
}

}  // namespace tims::link
