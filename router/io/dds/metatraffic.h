// The metatraffic of one participant (RTPS: discovery), between the library's threads, which take
// it, and the library, which gets what it needs (discovery_filter.h).
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include <fastdds/rtps/transport/TransportReceiverInterface.h>

#include "router/io/dds/discovery_filter.h"
#include "router/io/dds/news.h"
#include "router/io/dds/user_traffic.h"

namespace tims::io {

class Metatraffic {
 public:
  using Receiver = eprosima::fastdds::rtps::TransportReceiverInterface;

  Metatraffic(const link::Announcement& self, std::uint64_t life, std::shared_ptr<DdsNews> news,
              std::shared_ptr<UserTraffic> traffic)
      : life_(life), news_(std::move(news)), traffic_(std::move(traffic)), filter_(self) {}

  // --- by the transport, in any thread

  void set_receiver(Receiver* receiver) { receiver_ = receiver; }
  void receive(Receiver& next, std::span<const std::byte> message, const Locator& local,
               const Locator& remote);
  // A message of ours.
  void sent(std::span<const std::byte> message);

  // --- by the thread that makes the participant, while there is one

  // The library discovers this router, if it has not yet.
  void admit(const link::DdsParticipant& who);

  // --- by the library's threads

  // It is discovered anew once it announces itself again.
  void forget(const link::DdsParticipant& who);

  // --- by the loop

  // Those that have been silent for their lease.
  std::vector<link::DdsParticipant> expire(Time now);

 private:
  const std::uint64_t life_;
  const std::shared_ptr<DdsNews> news_;
  const std::shared_ptr<UserTraffic> traffic_;
  std::atomic<Receiver*> receiver_ = nullptr;
  std::mutex mutex_;  // of what follows; not held while the library is called
  DiscoveryFilter filter_;
};

}  // namespace tims::io
