#include "router/io/dds/participant.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>
#include <fastdds/rtps/transport/TCPTransportDescriptor.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <fmt/core.h>

#include "router/core/random.h"
#include "router/io/dds/transport.h"
#include "router/io/net/addresses.h"

namespace tims::io {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using namespace std::chrono_literals;
using UdpDescriptor = eprosima::fastdds::rtps::UDPv4TransportDescriptor;
using TcpDescriptor = eprosima::fastdds::rtps::TCPTransportDescriptor;
using eprosima::fastrtps::types::ReturnCode_t;

constexpr unsigned kDomainMax = 232;  // the library terminates the process above this
// Number of ports at which a peer without port is searched.
constexpr std::uint32_t kParticipantsOfAHost = 16;
constexpr std::uint16_t kServerPort = 11811;  // as used by the library's own tools
constexpr int kReaderSamples = 256;
// For a router that starts alone, one would be enough, because others answer. When a whole fleet
// starts at once, some are lost.
constexpr std::uint32_t kInitialAnnouncements = 3;
// The library's own heartbeats, in addition to ours; their counts are lower, so readers ignore
// them.
constexpr Duration kLibraryHeartbeat = 250ms;
constexpr Duration kInitialPeriod = 300ms;
// Participants of one host, each with its own port: further ones find no free port.
constexpr std::uint32_t kParticipantPortsTried = 500;
// Minimum time between two repetitions of the same sample: a reader without room requests it
// constantly.
constexpr Duration kResendPause = 10ms;

Error invalid(const std::string& text) { return {Errc::kInvalidArgument, "dds: " + text}; }

struct Place {
  std::string host{};
  std::uint16_t port = 0;
};

// "10.9.1.1:7410"; without a port, the port is 0.
std::optional<Place> parse_place(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  Place place{text.substr(0, colon)};
  if (colon != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto [last, error] = std::from_chars(text.data() + colon + 1, end, place.port);
    if (error != std::errc() || last != end || place.port == 0) return std::nullopt;
  }
  const auto address = numeric_address(place.host, 1);
  return address && address->is_v4() ? std::optional(place) : std::nullopt;
}

// --- profiles

Result<fast::DomainParticipantQos> participant_profile(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return invalid(file + ": no such file");
  auto* factory = fast::DomainParticipantFactory::get_instance();
  // The library keeps profiles for the whole process and refuses a second one named "tims".
  eprosima::fastrtps::xmlparser::XMLProfileManager::DeleteInstance();
  if (factory->load_XML_profiles_file(file) != eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK)
    return invalid(file + " is not a file of Fast DDS profiles");
  fast::DomainParticipantQos qos;
  if (factory->get_participant_qos_from_profile(kDdsProfile, qos) !=
      eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK)
    return invalid(fmt::format("{} has no participant profile \"{}\"", file, kDdsProfile));
  return qos;
}

// Participants of one process communicate over UDP, like all others. Has no effect once
// participants exist.
void set_library() {
  eprosima::fastrtps::LibrarySettingsAttributes library;
  library.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(library);
}

// --- the participant

// Sends messages that need no IP fragments (or as configured), and accepts larger ones. When some
// of many fragments are lost, nothing arrives, and the remaining ones occupy the receiver's
// reassembly memory for 30 s.
class UdpTransport final : public UdpDescriptor {
 public:
  explicit UdpTransport(const DdsSettings& settings) : message_max_(settings.message_max) {
    sendBufferSize = receiveBufferSize = 4 << 20;
    maxInitialPeersRange = kParticipantsOfAHost;
    if (!settings.interface.empty()) interfaceWhiteList = {settings.interface};
  }
  [[nodiscard]] std::uint32_t max_message_size() const override { return message_max_; }

 private:
  std::uint32_t message_max_;
};

// UDP only: between containers of one host, shared memory is detected but does not work, and it
// leaves files behind.
Result<void> set_transport(fast::DomainParticipantQos& qos, const DdsSettings& settings) {
  auto& transport = qos.transport();
  if (transport.user_transports.empty() && transport.use_builtin_transports) {
    transport.use_builtin_transports = false;
    transport.user_transports.push_back(std::make_shared<UdpTransport>(settings));
  }
  // The loop writes, so a transport must never wait for room.
  for (const auto& descriptor : transport.user_transports) {
    if (dynamic_cast<const TcpDescriptor*>(descriptor.get()) != nullptr)
      return invalid(settings.profiles +
                     ": TCP is not a transport for routers: they would wait for "
                     "a router that does not read");
    if (auto* udp = dynamic_cast<UdpDescriptor*>(descriptor.get())) udp->non_blocking_send = true;
  }
  return {};
}

// The discovery port: the first free one of the DDS ports, in steps of two. By default the
// library derives it from the number of participants created in the process: after some restarts
// no peer would look there.
Result<void> set_discovery(fast::DomainParticipantQos& qos, const DdsSettings& settings) {
  auto& builtin = qos.wire_protocol().builtin;
  const auto& ports = qos.wire_protocol().port;
  const auto here = static_cast<std::uint16_t>(ports.getUnicastPort(settings.domain, 0));
  const auto all = static_cast<std::uint16_t>(ports.getMulticastPort(settings.domain));
  const Locator multicast = locator_at("239.255.0.1", all);
  if (builtin.metatrafficUnicastLocatorList.empty()) {  // not set by a profile
    builtin.metatrafficUnicastLocatorList.push_back(locator_at("0.0.0.0", here));
    if (settings.multicast) builtin.metatrafficMulticastLocatorList.push_back(multicast);
  }
  for (const std::string& peer : settings.peers) {
    const auto place = parse_place(peer);
    if (!place) return invalid("peer " + peer + " is not an IPv4 address with or without port");
    builtin.initialPeersList.push_back(locator_at(place->host, place->port));
  }
  // A list of peers replaces multicast.
  if (!settings.peers.empty() && settings.multicast) builtin.initialPeersList.push_back(multicast);
  return {};
}

Result<void> set_server(fast::DomainParticipantQos& qos, const DdsSettings& settings) {
  if (settings.discovery_server.empty()) return {};
  auto place = parse_place(settings.discovery_server);
  if (!place)
    return invalid("discovery server " + settings.discovery_server + " is not address:port");
  if (place->port == 0) place->port = kServerPort;
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.discoveryProtocol = rtps::DiscoveryProtocol_t::CLIENT;
  discovery.discoveryServer_client_syncperiod = dds_duration(250ms);
  rtps::RemoteServerAttributes server;
  rtps::get_server_client_default_guidPrefix(0, server.guidPrefix);
  server.metatrafficUnicastLocatorList.push_back(locator_at(place->host, place->port));
  discovery.m_DiscoveryServers.push_back(server);
  return {};
}

class Consumer final : public fast::LogConsumer {
 public:
  explicit Consumer(std::weak_ptr<DdsEvents> events) : events_(std::move(events)) {}

  // Called in the library's own thread.
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

std::string partition_of(const link::NetAddress& address) {
  const std::string text = address.to_string();
  return text.substr(text.find(':') + 1);
}

eprosima::fastrtps::Duration_t dds_duration(Duration of) {
  return {static_cast<std::int32_t>(of / 1s), static_cast<std::uint32_t>((of % 1s).count())};
}

Result<fast::DomainParticipantQos> participant_qos(const DdsSettings& settings) {
  if (settings.domain > kDomainMax)
    return invalid(fmt::format("domain {} is not within 0 and {}", settings.domain, kDomainMax));
  if (settings.fleet.empty()) return invalid("the fleet has no name");
  if (!settings.interface.empty()) {
    const auto place = parse_place(settings.interface);
    if (!place || place->port != 0)
      return invalid("interface " + settings.interface + " is not an address");
  }
  set_library();
  fast::DomainParticipantQos qos;
  if (!settings.profiles.empty()) {
    auto profile = participant_profile(settings.profiles);
    if (!profile) return profile.error();
    qos = *profile;
  }
  if (auto done = set_transport(qos, settings); !done) return done.error();
  if (auto done = set_discovery(qos, settings); !done) return done.error();
  if (auto done = set_server(qos, settings); !done) return done.error();
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  if (discovery.leaseDuration ==
      fast::DomainParticipantQos().wire_protocol().builtin.discovery_config.leaseDuration) {
    discovery.leaseDuration = dds_duration(settings.lease);
    discovery.leaseDuration_announcementperiod = dds_duration(settings.lease / 3);
    discovery.initial_announcements = {kInitialAnnouncements, dds_duration(kInitialPeriod)};
  }
  qos.wire_protocol().builtin.mutation_tries = kParticipantPortsTried;
  return qos;
}

std::uint16_t user_traffic_port(const fast::DomainParticipantQos& qos, unsigned domain) {
  const auto& ports = qos.wire_protocol().port;
  return static_cast<std::uint16_t>(ports.portBase + ports.domainIDGain * domain + ports.offsetd3);
}

// Keeps the settings made by a profile.
void carry(fast::DomainParticipantQos& qos, const std::shared_ptr<UserTraffic>& traffic,
           const std::shared_ptr<Metatraffic>& metatraffic) {
  auto& locators = qos.wire_protocol().default_unicast_locator_list;
  for (auto& descriptor : qos.transport().user_transports) {
    if (dynamic_cast<const UdpDescriptor*>(descriptor.get()) == nullptr) continue;
    descriptor = std::make_shared<DdsTransport>(descriptor, traffic, metatraffic);
    if (locators.empty()) locators.push_back(traffic->locator());
    return;
  }
}

// Chooses a value between two thirds and the whole of the period, so that routers started
// together do not announce themselves together.
void spread(eprosima::fastrtps::Duration_t& period, std::uint64_t random) {
  constexpr std::int64_t kSteps = 1024;
  const auto steps = kSteps - static_cast<std::int64_t>(core::spread(random) % (kSteps / 3));
  period = dds_duration(Duration(period.to_ns() / kSteps * steps));
}

// By default the library derives the prefix of a host from its addresses, once a process: routers
// that start before their networks would all be on the same host.
void identify(fast::DomainParticipantQos& qos, std::uint64_t epoch, std::uint64_t generation) {
  auto& prefix = qos.wire_protocol().prefix;
  if (prefix != rtps::c_GuidPrefix_Unknown) return;  // set by a profile
  constexpr std::uint64_t kVendor = 0x010F;          // eProsima's
  const auto put = [&](std::size_t at, std::size_t bytes, std::uint64_t value) {
    for (std::size_t i = bytes; i-- > 0; value >>= 8)
      prefix.value[at + i] = static_cast<rtps::octet>(value);
  };
  put(0, 2, kVendor);
  put(2, 8, epoch);
  put(10, 2, generation);
}

void announce(fast::DomainParticipantQos& qos, const link::Announcement& announcement) {
  qos.name(fmt::format("tims-router {}", announcement.identity.name.view()).c_str());
  std::vector<rtps::octet> octets;
  for (const std::byte byte : link::encode(announcement))
    octets.push_back(std::to_integer<rtps::octet>(byte));
  qos.user_data().data_vec(octets);
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  spread(discovery.leaseDuration_announcementperiod, announcement.identity.epoch);
  spread(discovery.initial_announcements.period, announcement.identity.epoch);
}

// KEEP_LAST would lose samples silently.
template <typename Qos>
void keep_all(Qos& qos, int samples) {
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.history().kind = fast::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_samples = samples;
  qos.resource_limits().max_samples_per_instance = samples;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().allocated_samples = 2;
}

void complete(fast::DataWriterQos& qos, const DdsSettings& settings, bool is_profile, bool asks) {
  keep_all(qos, static_cast<int>(settings.history));
  // Acknowledged samples stay until the room is needed. Volatile writers remove them immediately
  // and, in Fast DDS 2.9.1, also when a reader disappears, locking two mutexes in the opposite
  // order to the thread that repeats lost samples: the participant would deadlock.
  qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.reliability().max_blocking_time = {0, 0};
  if (is_profile) return;
  auto& times = qos.reliable_writer_qos().times;
  // A lost sample is detected with the next one and requested immediately.
  times.heartbeatPeriod =
      dds_duration(asks ? std::max(settings.heartbeat, kLibraryHeartbeat) : settings.heartbeat);
  times.nackResponseDelay = dds_duration(0ms);
  times.nackSupressionDuration = dds_duration(kResendPause);
  // Otherwise each sample carries a heartbeat once the history is full of samples acknowledged
  // long ago.
  qos.reliable_writer_qos().disable_heartbeat_piggyback = true;
  qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
}

void complete(fast::DataReaderQos& qos, bool is_profile) {
  keep_all(qos, kReaderSamples);
  qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  // Samples of others on our topic must not be larger than ours.
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
  if (is_profile) return;
  auto& times = qos.reliable_reader_qos().times;
  times.heartbeatResponseDelay = dds_duration(0ms);
}

void send_library_log_to(const std::shared_ptr<DdsEvents>& events) {
  fast::Log::ClearConsumers();
  fast::Log::SetVerbosity(fast::Log::Kind::Warning);
  fast::Log::RegisterConsumer(std::make_unique<Consumer>(events));
}

// --- callbacks in the library's threads

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
  identify(qos, wanted.self.identity.epoch, wanted.generation);
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

// A discovery server announces a participant only to participants that read a topic it writes. So
// every participant has a writer that never writes.
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
