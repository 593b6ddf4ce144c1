#include "router/io/dds/participant.h"

#include <algorithm>
#include <stdexcept>

#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>

namespace tims::io {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

link::DdsParticipant id_of(const rtps::GuidPrefix_t& prefix) {
  link::DdsParticipant id{};
  std::copy_n(prefix.value, id.size(), id.begin());
  return id;
}

// "010f6e1f0a00000001000000"
std::string partition_of(const link::NetAddress& address) {
  const std::string text = address.to_string();
  return text.substr(text.find(':') + 1);
}

template <typename T>
T* require(T* made, const char* what) {
  if (made == nullptr) throw std::runtime_error(std::string("no ") + what + " could be made");
  return made;
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

// --- what the library's threads call

class DdsParticipant::Discovery final : public fast::DomainParticipantListener {
 public:
  Discovery(std::string fleet, std::uint64_t life, std::shared_ptr<DdsNews> news)
      : fleet_(std::move(fleet)), life_(life), news_(std::move(news)) {}

  void on_participant_discovery(fast::DomainParticipant*,
                                rtps::ParticipantDiscoveryInfo&& info) override {
    using Info = rtps::ParticipantDiscoveryInfo;
    const bool there =
        info.status == Info::DISCOVERED_PARTICIPANT || info.status == Info::CHANGED_QOS_PARTICIPANT;
    DdsNews::Router router{.life = life_};
    if (there) router.announcement = read(info.info, fleet_);
    news_->has_seen(id_of(info.info.m_guid.guidPrefix), std::move(router));
  }

 private:
  const std::string fleet_;
  const std::uint64_t life_;
  const std::shared_ptr<DdsNews> news_;
};

class DdsParticipant::Arrival final : public fast::DataReaderListener {
 public:
  explicit Arrival(std::shared_ptr<DdsNews> news) : news_(std::move(news)) {}
  void on_data_available(fast::DataReader*) override { news_->has_data(); }

 private:
  const std::shared_ptr<DdsNews> news_;
};

class DdsParticipant::Writer::Match final : public fast::DataWriterListener {
 public:
  Match(std::shared_ptr<DdsPeer> peer, std::shared_ptr<DdsOrders> orders)
      : peer_(std::move(peer)), orders_(std::move(orders)) {}
  void on_publication_matched(fast::DataWriter*,
                              const fast::PublicationMatchedStatus& status) override {
    peer_->matched = status.current_count > 0;
    orders_->stir();
  }
  void forget() { peer_->matched = false; }

 private:
  const std::shared_ptr<DdsPeer> peer_;
  const std::shared_ptr<DdsOrders> orders_;
};

// --- the participant

DdsParticipant::DdsParticipant(const DdsSettings& settings, fast::DomainParticipantQos qos,
                               const DdsOrders::Wanted& wanted, std::shared_ptr<DdsNews> news,
                               std::shared_ptr<DdsOrders> orders)
    : has_profiles_(!settings.profiles.empty()),
      orders_(std::move(orders)),
      discovery_(std::make_unique<Discovery>(settings.fleet, wanted.life, news)),
      arrival_(std::make_unique<Arrival>(std::move(news))) {
  announce(qos, wanted.self);
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
  const bool is_profile = has_profiles_ && subscriber->get_datareader_qos_from_profile(
                                               kDdsProfile, qos) == ReturnCode_t::RETCODE_OK;
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
  complete(qos, false);
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

std::unique_ptr<DdsParticipant::Writer> DdsParticipant::make_writer(
    const std::shared_ptr<DdsPeer>& peer) {
  return std::make_unique<Writer>(*participant_, *topic_, has_profiles_, peer, orders_);
}

// --- a writer

DdsParticipant::Writer::Writer(fast::DomainParticipant& participant, fast::Topic& topic,
                               bool has_profiles, std::shared_ptr<DdsPeer> peer,
                               std::shared_ptr<DdsOrders> orders)
    : participant_(participant) {
  fast::PublisherQos where = fast::PUBLISHER_QOS_DEFAULT;
  where.partition().push_back(partition_of(peer->address).c_str());
  match_ = std::make_unique<Match>(std::move(peer), std::move(orders));
  publisher_ = require(participant.create_publisher(where), "publisher");
  fast::DataWriterQos qos = publisher_->get_default_datawriter_qos();
  const bool is_profile = has_profiles && publisher_->get_datawriter_qos_from_profile(
                                              kDdsProfile, qos) == ReturnCode_t::RETCODE_OK;
  complete(qos, is_profile);
  writer_ = publisher_->create_datawriter(&topic, qos, match_.get(),
                                          fast::StatusMask::publication_matched());
  if (writer_ == nullptr) participant.delete_publisher(publisher_);
  require(writer_, "writer");
}

DdsParticipant::Writer::~Writer() {
  publisher_->delete_datawriter(writer_);
  participant_.delete_publisher(publisher_);
  match_->forget();
}

void DdsParticipant::Writer::wait_until_arrived(Duration limit) {
  if (limit > Duration::zero()) writer_->wait_for_acknowledgments(dds_duration(limit));
}

// The history is full until the reader has acknowledged: the library says "timeout" or "out of
// resources", and has not kept the sample.
Written DdsParticipant::Writer::write(const SendQueue::Front& front) {
  sample_.parts = front.parts;
  const ReturnCode_t code = writer_->write(&sample_, rtps::InstanceHandle_t());
  if (code == ReturnCode_t::RETCODE_OK) return Written::kYes;
  const bool full =
      code == ReturnCode_t::RETCODE_TIMEOUT || code == ReturnCode_t::RETCODE_OUT_OF_RESOURCES;
  return full ? Written::kNotNow : Written::kNever;
}

}  // namespace tims::io
