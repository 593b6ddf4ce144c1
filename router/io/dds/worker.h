// The engine's thread: makes and ends participants and their writers, which may take long in the
// library.
#pragma once

#include <map>
#include <memory>

#include "router/io/dds/participant.h"

namespace tims::io {

class DdsWorker {
 public:
  DdsWorker(const DdsSettings& settings, const eprosima::fastdds::dds::DomainParticipantQos& qos,
            std::shared_ptr<DdsNews> news, std::shared_ptr<DdsOrders> orders);

  void run();  // until the end is ordered

 private:
  void obey(const DdsOrders::Wanted& wanted);
  void live(const DdsOrders::Wanted& wanted);
  void keep_writers(const DdsOrders::Wanted& wanted);

  const DdsSettings settings_;
  const eprosima::fastdds::dds::DomainParticipantQos qos_;
  const std::shared_ptr<DdsNews> news_;
  const std::shared_ptr<DdsOrders> orders_;
  std::uint64_t life_ = 0;
  std::unique_ptr<DdsParticipant> participant_;
  // Go before the participant does.
  std::map<std::shared_ptr<DdsPeer>, std::unique_ptr<DdsWriter>> writers_;
};

}  // namespace tims::io
