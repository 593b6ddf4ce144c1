#include "router/io/dds/qos.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/rtps/transport/TCPTransportDescriptor.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <fmt/core.h>

#include "router/core/random.h"
#include "router/io/dds/transport.h"
#include "router/io/net/system_address.h"

namespace tims::io {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using namespace std::chrono_literals;
using UdpDescriptor = eprosima::fastdds::rtps::UDPv4TransportDescriptor;
using TcpDescriptor = eprosima::fastdds::rtps::TCPTransportDescriptor;

constexpr unsigned kDomainMax = 232;                // the library ends the process beyond
constexpr std::uint32_t kParticipantsOfAHost = 16;  // where a peer without port is looked for
constexpr std::uint16_t kServerPort = 11811;        // as the library's own tools
constexpr int kReaderSamples = 256;
// For a router that starts alone one would do: others answer. Of a fleet that starts at once some
// are lost.
constexpr std::uint32_t kInitialAnnouncements = 3;
// What the library sends beside our heartbeats, which readers do not count.
constexpr Duration kLibraryHeartbeat = 250ms;
constexpr Duration kInitialPeriod = 300ms;
// Participants of one host, each at a port of its own: those beyond find none.
constexpr std::uint32_t kPortsTried = 500;
// Between two times that the same is sent again: to a reader without room, that is all the time.
constexpr Duration kResendPause = 10ms;

Error invalid(const std::string& text) { return {Errc::kInvalidArgument, "dds: " + text}; }

struct Place {
  std::string host{};
  std::uint16_t port = 0;
};

// "10.9.1.1:7410"; without port it is 0.
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
  // The library keeps what it has read for the whole process, and refuses a second "tims".
  eprosima::fastrtps::xmlparser::XMLProfileManager::DeleteInstance();
  if (factory->load_XML_profiles_file(file) != eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK)
    return invalid(file + " is no file of Fast DDS profiles");
  fast::DomainParticipantQos qos;
  if (factory->get_participant_qos_from_profile(kDdsProfile, qos) !=
      eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK)
    return invalid(fmt::format("{} has no participant profile \"{}\"", file, kDdsProfile));
  return qos;
}

// Participants of one process talk by UDP, as all others do. Ignored once there are some.
void set_library() {
  eprosima::fastrtps::LibrarySettingsAttributes library;
  library.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(library);
}

// --- the participant

// Sends messages that need no IP fragments (or as settings say), and takes larger ones. Where some
// of many fragments are lost, nothing arrives, and what is left of them fills the receiver's memory
// for 30 s.
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

// Only UDP: shared memory is found and does not work between containers of one host, and leaves
// files behind.
Result<void> set_transport(fast::DomainParticipantQos& qos, const DdsSettings& settings) {
  auto& transport = qos.transport();
  if (transport.user_transports.empty() && transport.use_builtin_transports) {
    transport.use_builtin_transports = false;
    transport.user_transports.push_back(std::make_shared<UdpTransport>(settings));
  }
  // The loop writes: it never waits for room.
  for (const auto& descriptor : transport.user_transports) {
    if (dynamic_cast<const TcpDescriptor*>(descriptor.get()) != nullptr)
      return invalid(settings.profiles +
                     ": TCP is no transport for routers: they would wait for "
                     "one that does not read");
    if (auto* udp = dynamic_cast<UdpDescriptor*>(descriptor.get())) udp->non_blocking_send = true;
  }
  return {};
}

// Where we are looked for: the first of the ports of DDS that is free, in steps of two. Left alone,
// the library counts participants for as long as a process lives and takes the port from the count:
// after some restarts nobody would look there.
Result<void> set_discovery(fast::DomainParticipantQos& qos, const DdsSettings& settings) {
  auto& builtin = qos.wire_protocol().builtin;
  const auto& ports = qos.wire_protocol().port;
  const auto here = static_cast<std::uint16_t>(ports.getUnicastPort(settings.domain, 0));
  const auto all = static_cast<std::uint16_t>(ports.getMulticastPort(settings.domain));
  const Locator multicast = locator_at("239.255.0.1", all);
  if (builtin.metatrafficUnicastLocatorList.empty()) {  // no profile says otherwise
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
  qos.wire_protocol().builtin.mutation_tries = kPortsTried;
  return qos;
}

std::uint16_t user_traffic_port(const fast::DomainParticipantQos& qos, unsigned domain) {
  const auto& ports = qos.wire_protocol().port;
  return static_cast<std::uint16_t>(ports.portBase + ports.domainIDGain * domain + ports.offsetd3);
}

// What a profile says of both stays.
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

// Between two thirds and all of it: a fleet that started at once does not announce itself at once.
void spread(eprosima::fastrtps::Duration_t& period, std::uint64_t random) {
  constexpr std::int64_t kSteps = 1024;
  const auto steps = kSteps - static_cast<std::int64_t>(core::spread(random) % (kSteps / 3));
  period = dds_duration(Duration(period.to_ns() / kSteps * steps));
}

void announce(fast::DomainParticipantQos& qos, const link::Announcement& announcement) {
  qos.name(fmt::format("tims-router {}", announcement.who.name.view()).c_str());
  std::vector<rtps::octet> octets;
  for (const std::byte byte : link::encode(announcement))
    octets.push_back(std::to_integer<rtps::octet>(byte));
  qos.user_data().data_vec(octets);
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  spread(discovery.leaseDuration_announcementperiod, announcement.who.epoch);
  spread(discovery.initial_announcements.period, announcement.who.epoch);
}

// KEEP_LAST would lose without a word.
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
  // What has been acknowledged stays until there is no room. Volatile writers take it out at once,
  // in Fast DDS 2.9.1 also when a reader goes, with two locks in the other order than the thread
  // that sends again what was lost: the participant would stand still forever.
  qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.reliability().max_blocking_time = {0, 0};
  if (is_profile) return;
  auto& times = qos.reliable_writer_qos().times;
  // What was lost is noticed by the next one, and asked for at once.
  times.heartbeatPeriod =
      dds_duration(asks ? std::max(settings.heartbeat, kLibraryHeartbeat) : settings.heartbeat);
  times.nackResponseDelay = dds_duration(0ms);
  times.nackSupressionDuration = dds_duration(kResendPause);
  // Else with each sample once the history is full of what was acknowledged long ago.
  qos.reliable_writer_qos().disable_heartbeat_piggyback = true;
  qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
}

void complete(fast::DataReaderQos& qos, bool is_profile) {
  keep_all(qos, kReaderSamples);
  qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  // Of others on our topic: nothing larger than ours.
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
  if (is_profile) return;
  auto& times = qos.reliable_reader_qos().times;
  times.heartbeatResponseDelay = dds_duration(0ms);
}

}  // namespace tims::io
