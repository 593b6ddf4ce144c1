// What lies between Fast DDS and the network: UDP as the library does it, but for the user traffic
// (RTPS: what is not discovery), which comes and goes by a socket of ours that the loop serves, and
// for the metatraffic (discovery), of which the library gets what it needs.
//
// Own code under a library wants a reason. The library's threads would take what arrives, one
// message at a time, and each would wait for one more thread to wake up; and Fast DDS makes
// endpoints towards everybody it discovers. README.md has what both buy, measured.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/rtps/common/Locator.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>

#include "router/io/dds/discovery_filter.h"
#include "router/io/net/udp_socket.h"
#include "router/link/transport.h"

namespace tims::io {

class DdsEvents;

// Where RTPS sends to and listens (IPv4 and UDP), and addresses of ours.
using Locator = eprosima::fastdds::rtps::Locator;

// `host`: "10.9.1.1"; 0.0.0.0 stands for all addresses.
Locator locator_at(const std::string& host, std::uint16_t port);
Locator locator_of(const link::NetAddress& address);
link::NetAddress address_of(const Locator& locator);

// The socket of one participant's user traffic (RTPS: what is not discovery), between the loop and
// the library. The library's own threads would take what arrives, and each message would wait for
// one more thread to wake up; so the loop takes it, and hands it to the library.
class UserTraffic {
 public:
  using Receiver = eprosima::fastdds::rtps::TransportReceiverInterface;

  // At the first free one of 16 ports from `port` on, in steps of two as DDS counts them, else at
  // any. An empty interface: at all addresses of this host.
  static Result<std::shared_ptr<UserTraffic>> open(const std::string& interface,
                                                   std::uint16_t port);
  UserTraffic(UdpSocket socket, const std::string& interface);

  // Where others send to; 0.0.0.0 stands for all addresses.
  [[nodiscard]] const Locator& locator() const { return locator_; }

  // --- by the thread that makes the participant

  void set_receiver(Receiver* receiver) { receiver_ = receiver; }
  [[nodiscard]] bool has_receiver() const { return receiver_ != nullptr; }

  // --- by the loop, while there is a participant

  [[nodiscard]] int fd() const { return socket_.fd(); }
  // Hands on some of what has arrived; listeners are called from here. Returns whom it came from,
  // until the next call.
  std::span<const link::DdsParticipant> receive();

  // What the library sends meanwhile from this thread goes out in few calls of the system, the last
  // of them at the end. What the system does not take is lost, and sent again by RTPS.
  class Cork {
   public:
    explicit Cork(UserTraffic& traffic) : traffic_(traffic) {
      traffic_.corked_by_ = std::this_thread::get_id();
    }
    Cork(const Cork&) = delete;
    Cork& operator=(const Cork&) = delete;
    ~Cork() {
      traffic_.corked_by_ = std::thread::id();
      traffic_.flush();
    }

   private:
    UserTraffic& traffic_;
  };

  // --- by the transport, in any thread

  [[nodiscard]] bool is_corked() const { return corked_by_ == std::this_thread::get_id(); }
  // `to`: all addresses of the receiver, as the library does it; whoever gets it twice drops one.
  void put(std::span<const std::byte> message, std::span<const link::NetAddress> to);
  // By itself, at once.
  void send(std::span<const std::byte> message, std::span<const link::NetAddress> to);
  // Where the last message of put() went.
  void last_to(std::vector<link::NetAddress>& to);
  // Before anything goes another way: a heartbeat that overtakes what it tells of would have that
  // sent again.
  void flush();

 private:
  void flush_locked();

  UdpSocket socket_;
  const Locator locator_;
  Receiver* receiver_ = nullptr;
  Datagrams arrived_;
  std::vector<link::DdsParticipant> heard_;

  std::atomic<std::thread::id> corked_by_{};
  std::mutex mutex_;  // of what follows
  std::vector<link::NetAddress> to_{};
  std::vector<std::byte> burst_{};
  std::size_t message_size_ = 0;  // of all but the last
};

// The metatraffic of one participant (RTPS: discovery), between the library's threads, which take
// it, and the library, which gets what it needs (discovery_filter.h).
class Metatraffic {
 public:
  using Receiver = eprosima::fastdds::rtps::TransportReceiverInterface;

  Metatraffic(const link::Announcement& self, std::uint64_t generation,
              std::shared_ptr<DdsEvents> events, std::shared_ptr<UserTraffic> traffic)
      : generation_(generation),
        events_(std::move(events)),
        traffic_(std::move(traffic)),
        filter_(self) {}

  // --- by the transport, in any thread

  void set_receiver(Receiver* receiver) { receiver_ = receiver; }
  void receive(Receiver& next, std::span<const std::byte> message, const Locator& local,
               const Locator& remote);
  // A message of ours.
  void sent(std::span<const std::byte> message);

  // --- by the thread that makes the participant, while there is one

  // The library discovers this router, if it has not yet.
  void admit(const link::DdsParticipant& who);

  // --- by the library's threads

  // It is discovered anew once it announces itself again.
  void forget(const link::DdsParticipant& who);

  // --- by the loop

  // Those that have been silent for their lease.
  std::vector<link::DdsParticipant> expire(Time now);

 private:
  const std::uint64_t generation_;
  const std::shared_ptr<DdsEvents> events_;
  const std::shared_ptr<UserTraffic> traffic_;
  std::atomic<Receiver*> receiver_ = nullptr;
  std::mutex mutex_;  // of what follows; not held while the library is called
  DiscoveryFilter filter_;
};

// UDP as the library does it, but for the user traffic, which comes and goes by a socket of ours,
// and for discovery, of which the library gets what it needs.
struct DdsTransport final : eprosima::fastdds::rtps::ChainingTransportDescriptor {
  using Udp = std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface>;

  DdsTransport(Udp udp, std::shared_ptr<UserTraffic> user_traffic,
               std::shared_ptr<Metatraffic> discovery)
      : ChainingTransportDescriptor(std::move(udp)),
        traffic(std::move(user_traffic)),
        metatraffic(std::move(discovery)) {}
  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override;
  // After so many bytes a writer asks all its readers what they have got. Fast DDS 2.9.1 counts
  // with each sample all that the participant's sending thread has ever sent, so a router that has
  // told many of its endpoints would ask all of them with each sample to one.
  [[nodiscard]] std::uint32_t min_send_buffer_size() const override {
    return std::numeric_limits<std::int32_t>::max();
  }

  std::shared_ptr<UserTraffic> traffic;
  std::shared_ptr<Metatraffic> metatraffic;  // none: the library gets all
};

}  // namespace tims::io
