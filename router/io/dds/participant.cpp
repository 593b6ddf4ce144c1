#include "router/io/dds/participant.h"

#include <algorithm>

#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>

#include "router/io/dds/qos.h"

namespace tims::io {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

class Consumer final : public fast::LogConsumer {
 public:
  explicit Consumer(std::weak_ptr<DdsEvents> events) : events_(std::move(events)) {}

  // In the library's own thread.
  void Consume(const fast::Log::Entry& entry) override {
    const auto events = events_.lock();
    if (!events) return;
    const char* category = entry.context.category != nullptr ? entry.context.category : "";
    events->post_line({.error = entry.kind == fast::Log::Kind::Error,
                       .text = std::string(category) + ": " + entry.message});
  }

 private:
  const std::weak_ptr<DdsEvents> events_;
};

link::DdsParticipant id_of(const rtps::GuidPrefix_t& prefix) {
  link::DdsParticipant id{};
  std::copy_n(prefix.value, id.size(), id.begin());
  return id;
}

std::optional<link::Announcement> read(const rtps::ParticipantProxyData& data,
                                       std::string_view fleet) {
  const auto& octets = data.m_userData;
  auto announcement = link::decode_announcement(std::as_bytes(std::span(octets)));
  if (!announcement || announcement->fleet.view() != fleet) return std::nullopt;
  announcement->dds = link::NetAddress::dds(id_of(data.m_guid.guidPrefix));
  return announcement;
}

}  // namespace

void send_library_log_to(const std::shared_ptr<DdsEvents>& events) {
  fast::Log::ClearConsumers();
  fast::Log::SetVerbosity(fast::Log::Kind::Warning);
  fast::Log::RegisterConsumer(std::make_unique<Consumer>(events));
}

// --- what the library's threads call

class DdsParticipant::Discovery final : public fast::DomainParticipantListener {
 public:
  Discovery(std::string fleet, const DdsCommands::Wanted& wanted, std::shared_ptr<DdsEvents> events)
      : fleet_(std::move(fleet)),
        generation_(wanted.generation),
        metatraffic_(wanted.metatraffic),
        events_(std::move(events)) {}

  void on_participant_discovery(fast::DomainParticipant*,
                                rtps::ParticipantDiscoveryInfo&& info) override {
    using Info = rtps::ParticipantDiscoveryInfo;
    const bool there =
        info.status == Info::DISCOVERED_PARTICIPANT || info.status == Info::CHANGED_QOS_PARTICIPANT;
    DdsEvents::Router router{.generation = generation_};
    if (there) router.announcement = read(info.info, fleet_);
    const link::DdsParticipant id = id_of(info.info.m_guid.guidPrefix);
    if (!there && metatraffic_) metatraffic_->forget(id);
    events_->post_router(id, std::move(router));
  }

 private:
  const std::string fleet_;
  const std::uint64_t generation_;
  const std::shared_ptr<Metatraffic> metatraffic_;
  const std::shared_ptr<DdsEvents> events_;
};

class DdsParticipant::Arrival final : public fast::DataReaderListener {
 public:
  explicit Arrival(std::shared_ptr<DdsEvents> events) : events_(std::move(events)) {}
  void on_data_available(fast::DataReader*) override { events_->wake(); }

 private:
  const std::shared_ptr<DdsEvents> events_;
};

// --- the participant

DdsParticipant::DdsParticipant(const DdsSettings& settings, fast::DomainParticipantQos qos,
                               const DdsCommands::Wanted& wanted, std::shared_ptr<DdsEvents> events)
    : settings_(settings),
      events_(std::move(events)),
      traffic_(wanted.traffic),
      metatraffic_(wanted.metatraffic),
      discovery_(std::make_unique<Discovery>(settings.fleet, wanted, events_)),
      arrival_(std::make_unique<Arrival>(events_)) {
  announce(qos, wanted.self);
  carry(qos, traffic_, metatraffic_);
  participant_ = require(fast::DomainParticipantFactory::get_instance()->create_participant(
                             settings.domain, qos, discovery_.get(), fast::StatusMask::none()),
                         "participant");
  try {
    fast::TypeSupport type(new OctetsType);
    type.register_type(participant_);
    topic_ = require(participant_->create_topic("tims/" + settings.fleet, OctetsType::kName,
                                                fast::TOPIC_QOS_DEFAULT),
                     "topic");
    make_reader();
    if (qos.wire_protocol().builtin.discovery_config.discoveryProtocol !=
        rtps::DiscoveryProtocol_t::SIMPLE)
      make_presence();
  } catch (...) {
    remove();
    throw;
  }
}

void DdsParticipant::make_reader() {
  fast::SubscriberQos where = fast::SUBSCRIBER_QOS_DEFAULT;
  where.partition().push_back(partition_of(address()).c_str());
  auto* subscriber = require(participant_->create_subscriber(where), "subscriber");
  fast::DataReaderQos qos = subscriber->get_default_datareader_qos();
  const bool is_profile =
      !settings_.profiles.empty() &&
      subscriber->get_datareader_qos_from_profile(kDdsProfile, qos) == ReturnCode_t::RETCODE_OK;
  complete(qos, is_profile);
  reader_ = require(subscriber->create_datareader(topic_, qos, arrival_.get(),
                                                  fast::StatusMask::data_available()),
                    "reader");
}

// A discovery server tells a participant of another one only when one writes what the other reads,
// by the names of topics. So all have a writer, which never writes.
void DdsParticipant::make_presence() {
  fast::PublisherQos where = fast::PUBLISHER_QOS_DEFAULT;
  where.partition().push_back(partition_of(address()).c_str());
  auto* publisher = require(participant_->create_publisher(where), "publisher");
  fast::DataWriterQos qos = publisher->get_default_datawriter_qos();
  complete(qos, settings_, false, false);
  require(publisher->create_datawriter(topic_, qos), "writer");
}

DdsParticipant::~DdsParticipant() { remove(); }

void DdsParticipant::remove() {
  participant_->delete_contained_entities();
  fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
}

link::NetAddress DdsParticipant::address() const {
  return link::NetAddress::dds(id_of(participant_->guid().guidPrefix));
}

std::unique_ptr<DdsWriter> DdsParticipant::make_writer(const std::shared_ptr<DdsPeer>& peer) {
  if (metatraffic_) metatraffic_->admit(peer->address.participant());
  const DdsWriter::Place place{*participant_, *topic_, settings_};
  return std::make_unique<DdsWriter>(place, peer, events_, traffic_);
}

}  // namespace tims::io
