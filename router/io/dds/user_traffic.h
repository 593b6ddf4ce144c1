// The socket of one participant's user traffic (RTPS: what is not discovery), between the loop and
// the library. The library's own threads would take what arrives, and each message would wait for
// one more thread to wake up; so the loop takes it, and hands it to the library.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/rtps/transport/TransportReceiverInterface.h>

#include "router/io/dds/locator.h"
#include "router/io/net/datagrams.h"
#include "router/io/net/udp_socket.h"

namespace tims::io {

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
  std::vector<std::byte> train_{};
  std::size_t message_size_ = 0;  // of all but the last
};

}  // namespace tims::io
