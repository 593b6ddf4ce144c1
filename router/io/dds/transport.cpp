#include "router/io/dds/transport.h"

#include <algorithm>
#include <atomic>

#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastrtps/utils/IPLocator.h>

#include "os/clock.h"
#include "router/io/dds/discovery_filter.h"
#include "router/io/dds/events.h"

namespace tims::io {
namespace {

namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastdds::rtps::ChainingTransport;
using eprosima::fastdds::rtps::TransportDescriptorInterface;
using rtps::LocatorsIterator;
using rtps::octet;

constexpr std::size_t kIpv4At = 12;  // of a locator's sixteen bytes

constexpr int kTransportPortsTried = 16;

std::string host_of(const std::string& interface) {
  return interface.empty() ? "0.0.0.0" : interface;
}

void hand_on(Metatraffic::Receiver& receiver, std::span<const std::byte> message,
             const Locator& local, const Locator& remote) {
  receiver.OnDataReceived(reinterpret_cast<const octet*>(message.data()),
                          static_cast<std::uint32_t>(message.size()), local, remote);
}

bool is_unicast(const Locator& locator) {
  return locator.kind == LOCATOR_KIND_UDPv4 && !rtps::IPLocator::isMulticast(locator);
}

class Transport final : public ChainingTransport {
 public:
  explicit Transport(const DdsTransport& descriptor)
      : ChainingTransport(descriptor), descriptor_(descriptor) {}

  TransportDescriptorInterface* get_configuration() override { return &descriptor_; }

  bool IsInputChannelOpen(const Locator& locator) const override {
    return is_user_traffic(locator) ? traffic().has_receiver()
                                    : ChainingTransport::IsInputChannelOpen(locator);
  }

  bool OpenInputChannel(const Locator& locator, UserTraffic::Receiver* receiver,
                        std::uint32_t message_max) override {
    if (!is_user_traffic(locator)) {
      if (metatraffic() != nullptr) metatraffic()->set_receiver(receiver);
      return ChainingTransport::OpenInputChannel(locator, receiver, message_max);
    }
    traffic().set_receiver(receiver);
    return true;
  }

  bool CloseInputChannel(const Locator& locator) override {
    if (!is_user_traffic(locator)) return ChainingTransport::CloseInputChannel(locator);
    traffic().set_receiver(nullptr);
    return true;
  }

  // The library sends each message through all its sockets: it has more than one for multicast.
  bool send(rtps::SenderResource* socket, const octet* message, std::uint32_t size,
            LocatorsIterator* first, LocatorsIterator* last,
            const std::chrono::steady_clock::time_point& limit) override {
    if (!traffic().is_corked()) {
      traffic().flush();
      if (metatraffic() != nullptr) metatraffic()->sent(std::as_bytes(std::span(message, size)));
      return socket->send(message, size, first, last, limit);
    }
    const rtps::SenderResource* none = nullptr;
    first_socket_.compare_exchange_strong(none, socket);
    if (socket != first_socket_) return true;
    to_.clear();
    for (LocatorsIterator& to = *first; to != *last; ++to)
      if (is_unicast(*to)) to_.push_back(address_of(*to));
    traffic().put(std::as_bytes(std::span(message, size)), to_);
    return true;
  }

  void receive(UserTraffic::Receiver* next, const octet* message, std::uint32_t size,
               const Locator& local, const Locator& remote) override {
    if (metatraffic() == nullptr) return next->OnDataReceived(message, size, local, remote);
    metatraffic()->receive(*next, std::as_bytes(std::span(message, size)), local, remote);
  }

 private:
  [[nodiscard]] UserTraffic& traffic() const { return *descriptor_.traffic; }
  [[nodiscard]] Metatraffic* metatraffic() const { return descriptor_.metatraffic.get(); }
  [[nodiscard]] bool is_user_traffic(const Locator& locator) const {
    return is_unicast(locator) && locator.port == traffic().locator().port;
  }

  DdsTransport descriptor_;
  std::atomic<const rtps::SenderResource*> first_socket_ = nullptr;
  std::vector<link::NetAddress> to_;  // of one message of the thread that holds the cork
};

}  // namespace

Locator locator_at(const std::string& host, std::uint16_t port) {
  Locator locator;
  eprosima::fastrtps::rtps::IPLocator::createLocator(LOCATOR_KIND_UDPv4, host, port, locator);
  return locator;
}

Locator locator_of(const link::NetAddress& address) {
  Locator locator;
  locator.kind = LOCATOR_KIND_UDPv4;
  locator.port = address.port;
  std::copy_n(address.ip.end() - 4, 4, locator.address + kIpv4At);
  return locator;
}

link::NetAddress address_of(const Locator& locator) {
  const auto* ip = locator.address + kIpv4At;
  return link::NetAddress::v4(ip[0], ip[1], ip[2], ip[3], static_cast<std::uint16_t>(locator.port));
}

Result<std::shared_ptr<UserTraffic>> UserTraffic::open(const std::string& interface,
                                                       std::uint16_t port) {
  const auto open_at = [&](int at) {
    return UdpSocket::open({host_of(interface), static_cast<std::uint16_t>(at)},
                           {.fragments = true});
  };
  Result<UdpSocket> socket = open_at(port);
  for (int i = 1;
       i < kTransportPortsTried && !socket && socket.error().code() == Errc::kAddressInUse; ++i)
    socket = open_at(port + 2 * i);
  if (!socket) socket = open_at(0);
  if (!socket) return socket.error();
  return std::make_shared<UserTraffic>(std::move(*socket), interface);
}

UserTraffic::UserTraffic(UdpSocket socket, const std::string& interface)
    : socket_(std::move(socket)), locator_(locator_at(host_of(interface), socket_.local().port)) {
  burst_.reserve(link::kBurstBytesMax);
}

std::span<const link::DdsParticipant> UserTraffic::receive() {
  senders_.clear();
  if (!socket_.receive(arrived_) || receiver_ == nullptr) return senders_;
  arrived_.for_each_datagram([this](const link::NetAddress& from, std::span<std::byte> datagram) {
    receiver_->OnDataReceived(reinterpret_cast<const octet*>(datagram.data()),
                              static_cast<std::uint32_t>(datagram.size()), locator_,
                              locator_of(from));
    const auto sender = rtps_sender(datagram);
    if (sender && (senders_.empty() || senders_.back() != *sender)) senders_.push_back(*sender);
  });
  return senders_;
}

// A message that is shorter than the previous ones ends their burst.
void UserTraffic::put(std::span<const std::byte> message, std::span<const link::NetAddress> to) {
  const std::lock_guard lock(mutex_);
  const bool fits = std::ranges::equal(to, to_) && message.size() <= message_size_ &&
                    burst_.size() % message_size_ == 0 &&
                    burst_.size() + message.size() <= link::kBurstBytesMax &&
                    burst_.size() < link::kBurstDatagramsMax * message_size_;
  if (!fits) {
    flush_locked();
    to_.assign(to.begin(), to.end());
    message_size_ = message.size();
  }
  burst_.insert(burst_.end(), message.begin(), message.end());
}

void UserTraffic::send(std::span<const std::byte> message, std::span<const link::NetAddress> to) {
  const std::lock_guard lock(mutex_);
  for (const link::NetAddress& address : to)
    (void)socket_.send({.to = address, .bytes = message, .datagram_size = message.size()});
}

void UserTraffic::last_to(std::vector<link::NetAddress>& to) {
  const std::lock_guard lock(mutex_);
  to.assign(to_.begin(), to_.end());
}

void UserTraffic::flush() {
  const std::lock_guard lock(mutex_);
  flush_locked();
}

void UserTraffic::flush_locked() {
  if (burst_.empty()) return;
  for (const link::NetAddress& to : to_)
    (void)socket_.send({.to = to, .bytes = burst_, .datagram_size = message_size_});
  burst_.clear();
}

void Metatraffic::receive(Receiver& next, std::span<const std::byte> message, const Locator& local,
                          const Locator& remote) {
  DiscoveryFilter::Verdict verdict;
  {
    const std::lock_guard lock(mutex_);
    verdict = filter_.on_message(os::now(), message,
                                 eprosima::fastrtps::rtps::IPLocator::isMulticast(local));
  }
  if (verdict.announced)
    events_->post_router(verdict.announced->dds.participant(),
                         {.generation = generation_, .announcement = *verdict.announced});
  if (verdict.gone) events_->post_router(*verdict.gone, {.generation = generation_});
  if (!verdict.answer.empty()) traffic_->send(verdict.answer, verdict.to);
  if (!verdict.first.empty()) hand_on(next, verdict.first, local, remote);
  if (verdict.passes) hand_on(next, message, local, remote);
}

void Metatraffic::sent(std::span<const std::byte> message) {
  const std::lock_guard lock(mutex_);
  filter_.on_own(message);
}

void Metatraffic::admit(const link::DdsParticipant& participant) {
  std::vector<std::byte> announced;
  {
    const std::lock_guard lock(mutex_);
    announced = filter_.admit(participant);
  }
  Receiver* const receiver = receiver_;
  if (receiver != nullptr && !announced.empty()) hand_on(*receiver, announced, {}, {});
}

void Metatraffic::forget(const link::DdsParticipant& participant) {
  const std::lock_guard lock(mutex_);
  filter_.forget(participant);
}

std::vector<link::DdsParticipant> Metatraffic::expire(Time now) {
  const std::lock_guard lock(mutex_);
  return filter_.expire(now);
}

eprosima::fastdds::rtps::TransportInterface* DdsTransport::create_transport() const {
  return new Transport(*this);
}

}  // namespace tims::io
