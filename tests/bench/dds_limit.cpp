#include "tests/bench/dds_limit.h"

#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <functional>
#include <mutex>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/TCPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include "libtims/os/clock.h"
#include "tests/bench/dds_host.h"
#include "tests/bench/message.h"
#include "tests/bench/metrics.h"
#include "tests/bench/usage.h"

namespace tims::bench {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
namespace transport = eprosima::fastdds::rtps;
using Octets = std::vector<std::byte>;

constexpr std::size_t kEncapsulation = 4;
constexpr std::size_t kLarge = 64 << 10;  // more than one UDP datagram
constexpr Duration kDdsLimitPatience = std::chrono::seconds(10);

class OctetsType final : public fast::TopicDataType {
 public:
  explicit OctetsType(std::size_t size_max) {
    setName("octets");
    m_typeSize = static_cast<std::uint32_t>(size_max + kEncapsulation);
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Octets& octets = *static_cast<const Octets*>(data);
    payload->encapsulation = CDR_LE;
    payload->length = static_cast<std::uint32_t>(octets.size() + kEncapsulation);
    constexpr unsigned char kHeader[kEncapsulation] = {0, 1, 0, 0};
    std::memcpy(payload->data, kHeader, kEncapsulation);
    std::memcpy(payload->data + kEncapsulation, octets.data(), octets.size());
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    Octets& octets = *static_cast<Octets*>(data);
    octets.resize(payload->length - kEncapsulation);
    std::memcpy(octets.data(), payload->data + kEncapsulation, octets.size());
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void*) override {
    return [this] { return m_typeSize; };
  }
  void* createData() override { return new Octets; }
  void deleteData(void* data) override { delete static_cast<Octets*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

// Deep enough that the history never becomes full: acknowledgements arrive with the heartbeat, and
// a write refused in the library's callback cannot be retried.
template <typename Qos>
void set_common(const Plan& plan, Qos& qos) {
  const int depth = plan.payload < kLarge ? 1024 : 32;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.history().kind = fast::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_samples = depth;
  qos.resource_limits().max_samples_per_instance = depth;
  qos.resource_limits().allocated_samples = 16;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
}

constexpr std::uint16_t kTcpPort = 5100;

std::shared_ptr<transport::TransportDescriptorInterface> udp() {
  auto udp = std::make_shared<transport::UDPv4TransportDescriptor>();
  udp->sendBufferSize = udp->receiveBufferSize = 4 << 20;
  return udp;
}

// As the library's examples for TCP: the receiver of pings listens, the sender connects.
void set_tcp(const Plan& plan, fast::DomainParticipantQos& qos) {
  auto tcp = std::make_shared<transport::TCPv4TransportDescriptor>();
  tcp->sendBufferSize = tcp->receiveBufferSize = 4 << 20;
  tcp->enable_tcp_nodelay = true;
  if (plan.sender()) {
    rtps::Locator_t server;
    server.kind = LOCATOR_KIND_TCPv4;
    rtps::IPLocator::setIPv4(server, plan.endpoint.substr(0, plan.endpoint.rfind(':')));
    server.port = kTcpPort;
    qos.wire_protocol().builtin.initialPeersList.push_back(server);
  } else {
    tcp->add_listener_port(kTcpPort);
  }
  qos.transport().user_transports.push_back(std::move(tcp));
}

// One end; the library's thread calls `on_octets`.
class End final : public fast::DataReaderListener {
 public:
  End(const Plan& plan, std::function<void(Octets&)> on_octets) : on_octets_(std::move(on_octets)) {
    wait_for_interface(plan.host);
    fast::DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    if (plan.link == "dds-tcp")
      set_tcp(plan, qos);
    else
      qos.transport().user_transports.push_back(udp());
    participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(0, qos);
    fast::TypeSupport(new OctetsType(plan.payload)).register_type(participant_);
    const bool pings = plan.sender();
    make_writer(plan, topic(pings ? "there" : "back"));
    make_reader(plan, topic(pings ? "back" : "there"));
  }
  ~End() override {
    writer_->wait_for_acknowledgments({1, 0});
    participant_->delete_contained_entities();
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  void write(Octets& octets) { writer_->write(&octets); }
  [[nodiscard]] bool is_matched() const {
    fast::PublicationMatchedStatus there;
    fast::SubscriptionMatchedStatus back;
    writer_->get_publication_matched_status(there);
    reader_->get_subscription_matched_status(back);
    return there.current_count > 0 && back.current_count > 0;
  }

  void on_data_available(fast::DataReader* reader) override {
    fast::SampleInfo info;
    while (reader->take_next_sample(&in_, &info) ==
           eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK)
      if (info.valid_data) on_octets_(in_);
  }

 private:
  fast::Topic* topic(const char* name) {
    return participant_->create_topic(name, "octets", fast::TOPIC_QOS_DEFAULT);
  }
  void make_writer(const Plan& plan, fast::Topic* topic) {
    fast::DataWriterQos qos;
    set_common(plan, qos);
    qos.reliable_writer_qos().times.heartbeatPeriod = {0, 2'000'000};
    qos.reliable_writer_qos().times.nackResponseDelay = {0, 0};
    if (plan.payload >= kLarge) qos.publish_mode().kind = fast::ASYNCHRONOUS_PUBLISH_MODE;
    writer_ =
        participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT)->create_datawriter(topic, qos);
  }
  void make_reader(const Plan& plan, fast::Topic* topic) {
    fast::DataReaderQos qos;
    set_common(plan, qos);
    qos.reliable_reader_qos().times.heartbeatResponseDelay = {0, 0};
    reader_ = participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)
                  ->create_datareader(topic, qos, this, fast::StatusMask::data_available());
  }

  std::function<void(Octets&)> on_octets_;
  Octets in_;
  fast::DomainParticipant* participant_ = nullptr;
  fast::DataWriter* writer_ = nullptr;
  fast::DataReader* reader_ = nullptr;
};

// Passed from the library's thread to the thread of the role.
class Signal {
 public:
  void raise() {
    {
      const std::lock_guard lock(mutex_);
      raised_ = true;
    }
    change_.notify_one();
  }
  bool wait(Duration limit) {
    std::unique_lock lock(mutex_);
    return change_.wait_for(lock, limit, [this] { return raised_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable change_;
  bool raised_ = false;
};

}  // namespace

bool dds_ping(const Plan& plan) {
  constexpr std::size_t kWarmUp = 100;
  constexpr std::size_t kRounds = 1'000'000;
  Signal over;
  std::vector<Duration> samples;
  samples.reserve(kRounds);
  Payload payload(plan.payload);
  Octets octets(plan.payload);
  Time start{};
  Time until = kNever;
  std::size_t rounds = 0;
  Usage before;
  End* end = nullptr;
  const auto send = [&](Kind kind) {
    const auto bytes = payload.with({.kind = kind, .seq = rounds});
    octets.assign(bytes.begin(), bytes.end());
    start = os::now();
    end->write(octets);
  };
  End here(plan, [&](Octets&) {
    const Time now = os::now();
    if (++rounds > kWarmUp) samples.push_back(now - start);
    if (rounds == kWarmUp) before = own_usage(), until = now + plan.seconds;
    if (now < until && samples.size() < kRounds) return send(Kind::kData);
    over.raise();
  });
  end = &here;
  for (const Time give_up = os::now() + kDdsLimitPatience;
       !here.is_matched() && os::now() < give_up;) {
  }
  send(Kind::kData);
  if (!over.wait(plan.seconds + kDdsLimitPatience)) {
    std::fprintf(stderr, "ping: the other side does not answer any more\n");
    return false;
  }
  print_usage(before, samples.size());
  print_latencies(samples);
  send(Kind::kEnd);
  return true;
}

bool dds_echo(const Plan& plan) {
  Signal over;
  End* end = nullptr;
  End here(plan, [&](Octets& octets) {
    if (head_of(octets).kind == Kind::kEnd) return over.raise();
    end->write(octets);
  });
  end = &here;
  return over.wait(plan.seconds + 3 * kDdsLimitPatience);
}

}  // namespace tims::bench
