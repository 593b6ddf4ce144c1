// One participant of Fast DDS, which exists until the host's addresses change, with the reader of
// samples sent to this router and a writer for each router we send to. Callbacks of the library's
// threads are converted to events. Also the settings (QoS) of all three: the configured values,
// and the reason for each deviation from the library's defaults.
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

// The partition read by this router alone: "010f6e1f0a00000001000000".
std::string partition_of(const link::NetAddress& address);

eprosima::fastrtps::Duration_t dds_duration(Duration of);

// The participant's settings without the announcement. Returns an error when the settings cannot
// work; reads the profiles.
Result<eprosima::fastdds::dds::DomainParticipantQos> participant_qos(const DdsSettings& settings);

// The user traffic port of the first participant on a host.
std::uint16_t user_traffic_port(const eprosima::fastdds::dds::DomainParticipantQos& qos,
                                unsigned domain);

void carry(eprosima::fastdds::dds::DomainParticipantQos& qos,
           const std::shared_ptr<UserTraffic>& traffic,
           const std::shared_ptr<Metatraffic>& metatraffic);

void announce(eprosima::fastdds::dds::DomainParticipantQos& qos,
              const link::Announcement& announcement);

// Completes the library's or a profile's settings. `asks`: heartbeats are sent by our own code.
void complete(eprosima::fastdds::dds::DataWriterQos& qos, const DdsSettings& settings,
              bool is_profile, bool asks);
void complete(eprosima::fastdds::dds::DataReaderQos& qos, bool is_profile);

// --- the participant

// Fast DDS has one log per process: it is sent to the most recently started engine, as long as
// `events` exists. Nothing is written to the terminal any more.
void send_library_log_to(const std::shared_ptr<DdsEvents>& events);

class DdsParticipant {
 public:
  // Throws std::runtime_error when the library cannot create it.
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
