#include "router/io/dds/metatraffic.h"

#include <fastrtps/utils/IPLocator.h>

#include "os/clock.h"

namespace tims::io {
namespace {

void hand_on(Metatraffic::Receiver& receiver, std::span<const std::byte> message,
             const Locator& local, const Locator& remote) {
  receiver.OnDataReceived(reinterpret_cast<const eprosima::fastrtps::rtps::octet*>(message.data()),
                          static_cast<std::uint32_t>(message.size()), local, remote);
}

}  // namespace

void Metatraffic::receive(Receiver& next, std::span<const std::byte> message, const Locator& local,
                          const Locator& remote) {
  DiscoveryFilter::Verdict verdict;
  {
    const std::lock_guard lock(mutex_);
    verdict = filter_.on_message(os::now(), message,
                                 eprosima::fastrtps::rtps::IPLocator::isMulticast(local));
  }
  if (verdict.announced)
    news_->has_seen(verdict.announced->dds.participant(),
                    {.life = life_, .announcement = *verdict.announced});
  if (verdict.gone) news_->has_seen(*verdict.gone, {.life = life_});
  if (!verdict.answer.empty()) traffic_->send(verdict.answer, verdict.to);
  if (!verdict.first.empty()) hand_on(next, verdict.first, local, remote);
  if (verdict.passes) hand_on(next, message, local, remote);
}

void Metatraffic::sent(std::span<const std::byte> message) {
  const std::lock_guard lock(mutex_);
  filter_.on_own(message);
}

void Metatraffic::admit(const link::DdsParticipant& who) {
  std::vector<std::byte> announced;
  {
    const std::lock_guard lock(mutex_);
    announced = filter_.admit(who);
  }
  Receiver* const receiver = receiver_;
  if (receiver != nullptr && !announced.empty()) hand_on(*receiver, announced, {}, {});
}

void Metatraffic::forget(const link::DdsParticipant& who) {
  const std::lock_guard lock(mutex_);
  filter_.forget(who);
}

std::vector<link::DdsParticipant> Metatraffic::expire(Time now) {
  const std::lock_guard lock(mutex_);
  return filter_.expire(now);
}

}  // namespace tims::io
