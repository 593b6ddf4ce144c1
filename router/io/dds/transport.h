// The layer between Fast DDS and the network: UDP as in the library, except for the user traffic
// (RTPS: everything but discovery), which uses a socket of ours served by the loop, and for the
// metatraffic (discovery), of which the library receives only what it needs.
//
// Reasons for own code below the library: its threads would receive one message at a time, each
// after waking one more thread; and Fast DDS creates endpoints for every participant it
// discovers. README.md has measurements of both.
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

// The address type of RTPS (IPv4 and UDP), and conversions of our addresses.
using Locator = eprosima::fastdds::rtps::Locator;

// `host`: "10.9.1.1"; 0.0.0.0 means all addresses.
Locator locator_at(const std::string& host, std::uint16_t port);
Locator locator_of(const link::NetAddress& address);
link::NetAddress address_of(const Locator& locator);

// The socket of one participant's user traffic (RTPS: everything but discovery), between the loop
// and the library. With the library's own threads, each message would wait for one more thread to
// wake up; so the loop receives it and passes it to the library.
class UserTraffic {
 public:
  using Receiver = eprosima::fastdds::rtps::TransportReceiverInterface;

  // Binds to the first free one of 16 ports from `port` on, in the steps of two used by DDS,
  // otherwise to any port. An empty interface means all addresses of this host.
  static Result<std::shared_ptr<UserTraffic>> open(const std::string& interface,
                                                   std::uint16_t port);
  UserTraffic(UdpSocket socket, const std::string& interface);

  // The address that others send to; 0.0.0.0 means all addresses.
  [[nodiscard]] const Locator& locator() const { return locator_; }

  // --- called by the thread that creates the participant

  void set_receiver(Receiver* receiver) { receiver_ = receiver; }
  [[nodiscard]] bool has_receiver() const { return receiver_ != nullptr; }

  // --- called by the loop, while there is a participant

  [[nodiscard]] int fd() const { return socket_.fd(); }
  // Passes some of the received messages to the library, which calls listeners from here. Returns
  // their senders, valid until the next call.
  std::span<const link::DdsParticipant> receive();

  // Collects messages that the library sends from this thread and sends them in few system calls,
  // the last of them in the destructor. Messages that the system does not accept are lost and
  // repeated by RTPS.
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

  // --- called by the transport, in any thread

  [[nodiscard]] bool is_corked() const { return corked_by_ == std::this_thread::get_id(); }
  // `to`: all addresses of the receiver, as in the library; a receiver drops duplicates.
  void put(std::span<const std::byte> message, std::span<const link::NetAddress> to);
  // Sends a single message immediately.
  void send(std::span<const std::byte> message, std::span<const link::NetAddress> to);
  // The destinations of the last message given to put().
  void last_to(std::vector<link::NetAddress>& to);
  // Called before anything is sent by another path: a heartbeat that overtakes its sample would
  // cause a repetition.
  void flush();

 private:
  void flush_locked();

  UdpSocket socket_;
  const Locator locator_;
  Receiver* receiver_ = nullptr;
  Datagrams arrived_;
  std::vector<link::DdsParticipant> senders_;

  std::atomic<std::thread::id> corked_by_{};
  std::mutex mutex_;  // protects the members below
  std::vector<link::NetAddress> to_{};
  std::vector<std::byte> burst_{};
  std::size_t message_size_ = 0;  // of all but the last
};

// The metatraffic (RTPS: discovery) of one participant, between the library's threads, which
// receive it, and the library, which gets what it needs (discovery_filter.h).
class Metatraffic {
 public:
  using Receiver = eprosima::fastdds::rtps::TransportReceiverInterface;

  Metatraffic(const link::Announcement& self, std::uint64_t generation,
              std::shared_ptr<DdsEvents> events, std::shared_ptr<UserTraffic> traffic)
      : generation_(generation),
        events_(std::move(events)),
        traffic_(std::move(traffic)),
        filter_(self) {}

  // --- called by the transport, in any thread

  void set_receiver(Receiver* receiver) { receiver_ = receiver; }
  void receive(Receiver& next, std::span<const std::byte> message, const Locator& local,
               const Locator& remote);
  // One of our own messages was sent.
  void sent(std::span<const std::byte> message);

  // --- called by the thread that creates the participant, while there is one

  // Lets the library discover this router, if it has not yet.
  void admit(const link::DdsParticipant& participant);

  // --- called by the library's threads

  // The participant is discovered again once it announces itself again.
  void forget(const link::DdsParticipant& participant);

  // --- called by the loop

  // Participants whose lease has expired.
  std::vector<link::DdsParticipant> expire(Time now);

 private:
  const std::uint64_t generation_;
  const std::shared_ptr<DdsEvents> events_;
  const std::shared_ptr<UserTraffic> traffic_;
  std::atomic<Receiver*> receiver_ = nullptr;
  std::mutex mutex_;  // protects the members below; not held while the library is called
  DiscoveryFilter filter_;
};

// UDP as in the library, except for the user traffic, which uses a socket of ours, and for
// discovery, of which the library receives only what it needs.
struct DdsTransport final : eprosima::fastdds::rtps::ChainingTransportDescriptor {
  using Udp = std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface>;

  DdsTransport(Udp udp, std::shared_ptr<UserTraffic> user_traffic,
               std::shared_ptr<Metatraffic> discovery)
      : ChainingTransportDescriptor(std::move(udp)),
        traffic(std::move(user_traffic)),
        metatraffic(std::move(discovery)) {}
  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override;
  // After this many bytes, a writer sends heartbeats to all its readers. Fast DDS 2.9.1 counts
  // all bytes ever sent by the participant's sending thread, so a router that has announced many
  // endpoints would send heartbeats to all of them with each sample to one.
  [[nodiscard]] std::uint32_t min_send_buffer_size() const override {
    return std::numeric_limits<std::int32_t>::max();
  }

  std::shared_ptr<UserTraffic> traffic;
  std::shared_ptr<Metatraffic> metatraffic;  // none: the library receives everything
};

}  // namespace tims::io
