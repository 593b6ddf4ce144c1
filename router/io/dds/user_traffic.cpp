#include "router/io/dds/user_traffic.h"

#include <algorithm>

#include "router/io/dds/rtps_message.h"

namespace tims::io {
namespace {

using eprosima::fastrtps::rtps::octet;

constexpr int kPortsTried = 16;

std::string host_of(const std::string& interface) {
  return interface.empty() ? "0.0.0.0" : interface;
}

}  // namespace

Result<std::shared_ptr<UserTraffic>> UserTraffic::open(const std::string& interface,
                                                       std::uint16_t port) {
  const auto open_at = [&](int at) {
    return UdpSocket::open({host_of(interface), static_cast<std::uint16_t>(at)},
                           {.fragments = true});
  };
  Result<UdpSocket> socket = open_at(port);
  for (int i = 1; i < kPortsTried && !socket && socket.error().code() == Errc::kAddressInUse; ++i)
    socket = open_at(port + 2 * i);
  if (!socket) socket = open_at(0);
  if (!socket) return socket.error();
  return std::make_shared<UserTraffic>(std::move(*socket), interface);
}

UserTraffic::UserTraffic(UdpSocket socket, const std::string& interface)
    : socket_(std::move(socket)), locator_(locator_at(host_of(interface), socket_.local().port)) {
  train_.reserve(link::kTrainBytesMax);
}

std::span<const link::DdsParticipant> UserTraffic::receive() {
  heard_.clear();
  if (!socket_.receive(arrived_) || receiver_ == nullptr) return heard_;
  arrived_.for_each_datagram([this](const link::NetAddress& from, std::span<std::byte> datagram) {
    receiver_->OnDataReceived(reinterpret_cast<const octet*>(datagram.data()),
                              static_cast<std::uint32_t>(datagram.size()), locator_,
                              locator_of(from));
    const auto sender = rtps_sender(datagram);
    if (sender && (heard_.empty() || heard_.back() != *sender)) heard_.push_back(*sender);
  });
  return heard_;
}

// A message that is shorter than those before it ends their train.
void UserTraffic::put(std::span<const std::byte> message, std::span<const link::NetAddress> to) {
  const std::lock_guard lock(mutex_);
  const bool fits = std::ranges::equal(to, to_) && message.size() <= message_size_ &&
                    train_.size() % message_size_ == 0 &&
                    train_.size() + message.size() <= link::kTrainBytesMax &&
                    train_.size() < link::kTrainDatagramsMax * message_size_;
  if (!fits) {
    flush_locked();
    to_.assign(to.begin(), to.end());
    message_size_ = message.size();
  }
  train_.insert(train_.end(), message.begin(), message.end());
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
  if (train_.empty()) return;
  for (const link::NetAddress& to : to_)
    (void)socket_.send({.to = to, .bytes = train_, .datagram_size = message_size_});
  train_.clear();
}

}  // namespace tims::io
