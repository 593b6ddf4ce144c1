// One participant of Fast DDS: from when it is made until the host's addresses change, with the
// reader of what is sent to this router and a writer for each router that is sent to. What the
// library's threads see is told as events. And the settings (QoS) of all three: what the
// configuration says, and why each value is not the library's.
#pragma once

#include <memory>
#include <string>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "router/io/dds/dds_engine.h"
#include "router/io/dds/events.h"
#include "router/io/dds/transport.h"
#include "router/io/dds/writer.h"

namespace tims::io {

// --- settings

inline constexpr const char* kDdsProfile = "tims";

// Which one router reads, and nobody else: "010f6e1f0a00000001000000".
std::string partition_of(const link::NetAddress& address);

eprosima::fastrtps::Duration_t dds_duration(Duration of);

// The participant without what it says of itself. Refused when the settings cannot work; reads the
// profiles.
Result<eprosima::fastdds::dds::DomainParticipantQos> participant_qos(const DdsSettings& settings);

// Where the first participant of a host has its user traffic.
std::uint16_t user_traffic_port(const eprosima::fastdds::dds::DomainParticipantQos& qos,
                                unsigned domain);

void carry(eprosima::fastdds::dds::DomainParticipantQos& qos,
           const std::shared_ptr<UserTraffic>& traffic,
           const std::shared_ptr<Metatraffic>& metatraffic);

void announce(eprosima::fastdds::dds::DomainParticipantQos& qos,
              const link::Announcement& announcement);

// To what is there: the library's own, or a profile. `asks`: heartbeats are sent by us.
void complete(eprosima::fastdds::dds::DataWriterQos& qos, const DdsSettings& settings,
              bool is_profile, bool asks);
void complete(eprosima::fastdds::dds::DataReaderQos& qos, bool is_profile);

// --- the participant

// Fast DDS has one log a process: it tells the engine that was started last, as long as `events`
// lives. Nothing goes to the terminal any more.
void send_library_log_to(const std::shared_ptr<DdsEvents>& events);

class DdsParticipant {
 public:
  // Throws std::runtime_error when the library does not make it.
  DdsParticipant(const DdsSettings& settings, eprosima::fastdds::dds::DomainParticipantQos qos,
                 const DdsCommands::Wanted& wanted, std::shared_ptr<DdsEvents> events);
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
  const std::shared_ptr<DdsEvents> events_;
  const std::shared_ptr<UserTraffic> traffic_;
  const std::shared_ptr<Metatraffic> metatraffic_;
  std::unique_ptr<Discovery> discovery_;
  std::unique_ptr<Arrival> arrival_;
  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
  eprosima::fastdds::dds::Topic* topic_ = nullptr;
  eprosima::fastdds::dds::DataReader* reader_ = nullptr;
};

}  // namespace tims::io
