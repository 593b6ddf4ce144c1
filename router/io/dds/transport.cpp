#include "router/io/dds/transport.h"

#include <algorithm>
#include <atomic>

#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastrtps/utils/IPLocator.h>

namespace tims::io {
namespace {

namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastdds::rtps::ChainingTransport;
using eprosima::fastdds::rtps::TransportDescriptorInterface;
using rtps::LocatorsIterator;
using rtps::octet;

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

  // The library sends each message by all its sockets: it has more than one for the sake of
  // multicast.
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
  std::vector<link::NetAddress> to_;  // of one message of the thread that corked
};

}  // namespace

eprosima::fastdds::rtps::TransportInterface* DdsTransport::create_transport() const {
  return new Transport(*this);
}

}  // namespace tims::io
