// A DDS participant that is not a tims router, for tests: it writes arbitrary data.
#pragma once

#include <string>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <gtest/gtest.h>

#include "router/io/dds/transport.h"
#include "router/io/dds/writer.h"
#include "router/link/datagram.h"

namespace tims::io {

class ForeignParticipant {
 public:
  using Qos = eprosima::fastdds::dds::DomainParticipantQos;

  static Qos udp_only() {
    Qos qos;
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(
        std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>());
    return qos;
  }
  // A discovery server of id 0.
  static Qos server(std::uint16_t port) {
    Qos qos = udp_only();
    auto& wire = qos.wire_protocol();
    auto& builtin = wire.builtin;
    builtin.discovery_config.discoveryProtocol =
        eprosima::fastrtps::rtps::DiscoveryProtocol_t::SERVER;
    eprosima::fastrtps::rtps::get_server_client_default_guidPrefix(0, wire.prefix);
    builtin.metatrafficUnicastLocatorList.push_back(locator_at("127.0.0.1", port));
    return qos;
  }
  // Announces itself as a router.
  static Qos router(const link::Announcement& announcement) {
    Qos qos = udp_only();
    std::vector<eprosima::fastrtps::rtps::octet> octets;
    for (const std::byte byte : link::encode(announcement))
      octets.push_back(std::to_integer<unsigned char>(byte));
    qos.user_data().data_vec(octets);
    return qos;
  }

  explicit ForeignParticipant(unsigned domain, const Qos& qos = udp_only())
      : participant_(factory()->create_participant(domain, qos)) {
    EXPECT_NE(participant_, nullptr);
  }
  ForeignParticipant(const ForeignParticipant&) = delete;
  ForeignParticipant& operator=(const ForeignParticipant&) = delete;
  ~ForeignParticipant() {
    participant_->delete_contained_entities();
    factory()->delete_participant(participant_);
  }

  void open(const std::string& topic, const std::string& partition) {
    namespace fast = eprosima::fastdds::dds;
    fast::TypeSupport type(new OctetsType);
    type.register_type(participant_);
    fast::PublisherQos where;
    where.partition().push_back(partition.c_str());
    fast::DataWriterQos qos;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().kind = fast::KEEP_ALL_HISTORY_QOS;
    qos.endpoint().history_memory_policy =
        eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    writer_ = participant_->create_publisher(where)->create_datawriter(
        participant_->create_topic(topic, OctetsType::kName, fast::TOPIC_QOS_DEFAULT), qos);
    ASSERT_NE(writer_, nullptr);
  }
  [[nodiscard]] bool is_matched() const {
    eprosima::fastdds::dds::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count > 0;
  }
  void write(std::span<const std::byte> bytes) {
    OctetsOut sample{.parts = {bytes, {}}};
    EXPECT_TRUE(writer_->write(&sample));
  }

 private:
  static eprosima::fastdds::dds::DomainParticipantFactory* factory() {
    return eprosima::fastdds::dds::DomainParticipantFactory::get_instance();
  }

  eprosima::fastdds::dds::DomainParticipant* participant_;
  eprosima::fastdds::dds::DataWriter* writer_ = nullptr;
};

}  // namespace tims::io
