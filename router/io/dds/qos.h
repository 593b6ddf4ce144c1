// How our participant, its writers and its reader are to be: what the settings say, and why each
// value is not the library's.
#pragma once

#include <optional>
#include <string>

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "router/io/dds/dds_engine.h"

namespace tims::io {

inline constexpr const char* kDdsProfile = "tims";

eprosima::fastrtps::Duration_t dds_duration(Duration of);

// The participant without what it says of itself. Refused when the settings cannot work; reads the
// profiles.
Result<eprosima::fastdds::dds::DomainParticipantQos> participant_qos(const DdsSettings& settings);

void announce(eprosima::fastdds::dds::DomainParticipantQos& qos,
              const link::Announcement& announcement);

// To what is there: the library's own, or a profile.
void complete(eprosima::fastdds::dds::DataWriterQos& qos, bool is_profile);
void complete(eprosima::fastdds::dds::DataReaderQos& qos, bool is_profile);

}  // namespace tims::io
