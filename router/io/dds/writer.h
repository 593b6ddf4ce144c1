// A writer that reaches one router only. Made and ended by the engine's thread, used by the loop.
#pragma once

#include <memory>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/topic/Topic.hpp>

#include "router/io/dds/dds_engine.h"
#include "router/io/dds/news.h"
#include "router/io/dds/octets_type.h"
#include "router/io/dds/orders.h"
#include "router/io/dds/rtps_message.h"

namespace tims::io {

enum class Written : std::uint8_t {
  kYes,
  kNotNow,  // the history is full of what the reader has not acknowledged
  kNever,
};

class DdsWriter {
 public:
  struct Place {
    eprosima::fastdds::dds::DomainParticipant& participant;
    eprosima::fastdds::dds::Topic& topic;
    const DdsSettings& settings;
  };

  // Throws std::runtime_error when the library does not make it.
  DdsWriter(const Place& place, std::shared_ptr<DdsPeer> peer, std::shared_ptr<DdsNews> news,
            std::shared_ptr<UserTraffic> traffic);
  DdsWriter(const DdsWriter&) = delete;
  DdsWriter& operator=(const DdsWriter&) = delete;
  ~DdsWriter();

  // May throw what the library throws. The bytes are copied.
  Written write(const OctetsOut& sample);
  // Whether all that was written has been acknowledged.
  [[nodiscard]] bool has_arrived();
  // Asks the reader what it has got: what it lacks is sent again. Nothing where the library does
  // that, as a profile says.
  void ask();

 private:
  class Match;

  eprosima::fastdds::dds::DomainParticipant& participant_;
  const std::shared_ptr<UserTraffic> traffic_;
  std::unique_ptr<Match> match_;
  eprosima::fastdds::dds::Publisher* publisher_ = nullptr;
  eprosima::fastdds::dds::DataWriter* writer_ = nullptr;
  bool asks_ = false;
  RtpsHeartbeat heartbeat_{};
  const std::uint32_t history_;
  std::vector<link::NetAddress> to_{};
};

}  // namespace tims::io
