// The engine's thread: makes and ends participants, and writes what waits. It alone calls what may
// take long in the library.
#pragma once

#include <map>
#include <memory>

#include "router/io/dds/participant.h"

namespace tims::io {

class DdsWorker {
 public:
  DdsWorker(const DdsSettings& settings, eprosima::fastdds::dds::DomainParticipantQos qos,
            std::shared_ptr<DdsNews> news, std::shared_ptr<DdsOrders> orders);

  void run();  // until the end is ordered

 private:
  struct Route {
    std::shared_ptr<DdsPeer> peer;
    std::unique_ptr<DdsParticipant::Writer> writer{};  // while there is a participant
    Time waits_since = kNever;                         // for its reader
    Time again_at{};                                   // when it could not be written
    Duration patience{};                               // until then
  };

  template <typename Work>
  Time guarded(Work work);
  Time finish(DdsOrders::Wanted& wanted);
  void obey(const DdsOrders::Wanted& wanted);
  void live(const DdsOrders::Wanted& wanted);
  void keep_routes(const DdsOrders::Wanted& wanted);
  // When to look again if nobody stirs.
  Time serve(Time now);
  Time serve(Time now, Route& route);
  Time wait_for_reader(Time now, Route& route);

  const DdsSettings settings_;
  const eprosima::fastdds::dds::DomainParticipantQos qos_;
  const std::shared_ptr<DdsNews> news_;
  const std::shared_ptr<DdsOrders> orders_;
  std::uint64_t life_ = 0;
  std::unique_ptr<DdsParticipant> participant_;
  std::map<link::NetAddress, Route> routes_;  // go before the participant does
};

}  // namespace tims::io
