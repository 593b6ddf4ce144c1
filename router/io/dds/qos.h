// How our participant, its writers and its reader are to be: what the settings say, and why each
// value is not the library's.
#pragma once

#include <memory>
#include <string>

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "router/io/dds/dds_engine.h"
#include "router/io/dds/transport.h"

namespace tims::io {

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

// To what is there: the library's own, or a profile.
// `asks`: heartbeats are sent by us.
void complete(eprosima::fastdds::dds::DataWriterQos& qos, const DdsSettings& settings,
              bool is_profile, bool asks);
void complete(eprosima::fastdds::dds::DataReaderQos& qos, bool is_profile);

}  // namespace tims::io
