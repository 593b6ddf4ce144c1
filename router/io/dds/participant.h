// One life of our participant: from when it is made until the host's addresses change.
#pragma once

#include <memory>
#include <string>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>

#include "router/io/dds/dds_engine.h"
#include "router/io/dds/news.h"
#include "router/io/dds/orders.h"
#include "router/io/dds/writer.h"

namespace tims::io {

class DdsParticipant {
 public:
  // Throws std::runtime_error when the library does not make it.
  DdsParticipant(const DdsSettings& settings, eprosima::fastdds::dds::DomainParticipantQos qos,
                 const DdsOrders::Wanted& wanted, std::shared_ptr<DdsNews> news);
  DdsParticipant(const DdsParticipant&) = delete;
  DdsParticipant& operator=(const DdsParticipant&) = delete;
  ~DdsParticipant();

  [[nodiscard]] link::NetAddress address() const;
  [[nodiscard]] eprosima::fastdds::dds::DataReader* reader() const { return reader_; }

  std::unique_ptr<DdsWriter> make_writer(const std::shared_ptr<DdsPeer>& peer);

 private:
  class Discovery;
  class Arrival;

  void make_reader();
  void make_presence();
  void remove();

  const DdsSettings& settings_;
  const std::shared_ptr<DdsNews> news_;
  const std::shared_ptr<UserTraffic> traffic_;
  const std::shared_ptr<Metatraffic> metatraffic_;
  std::unique_ptr<Discovery> discovery_;
  std::unique_ptr<Arrival> arrival_;
  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
  eprosima::fastdds::dds::Topic* topic_ = nullptr;
  eprosima::fastdds::dds::DataReader* reader_ = nullptr;
};

}  // namespace tims::io
