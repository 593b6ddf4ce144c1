// One life of our participant: from when it is made until the host's addresses change.
#pragma once

#include <memory>
#include <string>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>

#include "router/io/dds/news.h"
#include "router/io/dds/octets_type.h"
#include "router/io/dds/orders.h"
#include "router/io/dds/qos.h"

namespace tims::io {

class DdsParticipant {
 public:
  // Throws std::runtime_error when the library does not make it.
  DdsParticipant(const DdsSettings& settings, eprosima::fastdds::dds::DomainParticipantQos qos,
                 const DdsOrders::Wanted& wanted, std::shared_ptr<DdsNews> news,
                 std::shared_ptr<DdsOrders> orders);
  DdsParticipant(const DdsParticipant&) = delete;
  DdsParticipant& operator=(const DdsParticipant&) = delete;
  ~DdsParticipant();

  [[nodiscard]] link::NetAddress address() const;
  [[nodiscard]] eprosima::fastdds::dds::DataReader* reader() const { return reader_; }

  // A writer that reaches one router only.
  class Writer;
  std::unique_ptr<Writer> make_writer(const std::shared_ptr<DdsPeer>& peer);

 private:
  class Discovery;
  class Arrival;

  void make_reader();
  void make_presence();
  void remove();

  const bool has_profiles_;
  const std::shared_ptr<DdsOrders> orders_;
  std::unique_ptr<Discovery> discovery_;
  std::unique_ptr<Arrival> arrival_;
  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
  eprosima::fastdds::dds::Topic* topic_ = nullptr;
  eprosima::fastdds::dds::DataReader* reader_ = nullptr;
};

enum class Written : std::uint8_t { kYes, kNotNow, kNever };

class DdsParticipant::Writer {
 public:
  Writer(eprosima::fastdds::dds::DomainParticipant& participant,
         eprosima::fastdds::dds::Topic& topic, bool has_profiles, std::shared_ptr<DdsPeer> peer,
         std::shared_ptr<DdsOrders> orders);
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer();

  Written write(const SendQueue::Front& front);
  void wait_until_arrived(Duration limit);

 private:
  class Match;

  eprosima::fastdds::dds::DomainParticipant& participant_;
  std::unique_ptr<Match> match_;
  eprosima::fastdds::dds::Publisher* publisher_ = nullptr;
  eprosima::fastdds::dds::DataWriter* writer_ = nullptr;
  OctetsOut sample_{};
};

}  // namespace tims::io
