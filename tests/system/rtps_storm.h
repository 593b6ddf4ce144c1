// Forged datagrams of DDS (RTPS 2.3), as everybody on the network can send them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "os/file.h"

namespace tims::test {

// What gets past the filter of discovery and to the readers and writers of a link: participants
// that announce themselves with the user data of the fleet, and messages that claim to come from
// the router at the other end, whose number (the prefix of its GUIDs) everybody hears.
class RtpsStorm {
 public:
  // `user_data`: of an announcement in this fleet. `peer`: 24 hexadecimal digits.
  RtpsStorm(const std::vector<std::byte>& user_data, const std::string& peer) {
    for (const std::byte byte : user_data)
      user_data_.push_back(std::to_integer<std::uint8_t>(byte));
    user_data_.resize((user_data_.size() + 3) / 4 * 4);
    user_data_size_ = static_cast<std::uint32_t>(user_data.size());
    for (std::size_t i = 0; i + 1 < peer.size() && peer_.size() < kPrefixBytes; i += 2)
      peer_.push_back(static_cast<std::uint8_t>(std::stoul(peer.substr(i, 2), nullptr, 16)));
    peer_.resize(kPrefixBytes);
  }

  // To the first participants of a host: the announcement of another router.
  void announce(const char* host) { send_to_all(host, participant()); }
  // So many datagrams of each kind.
  void send(const char* host, int each) {
    for (int i = 0; i < each; ++i) {
      for (const auto& message :
           {participant(), heartbeat(), gap(), acknowledgement(), fragment(), noise()})
        send_to_all(host, message);
    }
  }

 private:
  using Bytes = std::vector<std::uint8_t>;
  static constexpr std::size_t kPrefixBytes = 12;
  enum Submessage : std::uint8_t {
    kAcknowledgement = 0x06,
    kHeartbeat = 0x07,
    kGap = 0x08,
    kData = 0x15,
    kDataFrag = 0x16
  };

  static void put(Bytes& out, std::uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8)
      out.push_back(static_cast<std::uint8_t>(value >> shift));
  }
  // Little endian, vendor eProsima.
  static Bytes message(const Bytes& from, Submessage kind, const Bytes& body) {
    Bytes out{'R', 'T', 'P', 'S', 2, 3, 1, 0x0F};
    out.insert(out.end(), from.begin(), from.end());
    out.insert(out.end(), {kind, static_cast<std::uint8_t>(kind == kData ? 5 : 1),
                           static_cast<std::uint8_t>(body.size() & 0xFF),
                           static_cast<std::uint8_t>(body.size() >> 8)});
    out.insert(out.end(), body.begin(), body.end());
    return out;
  }
  Bytes somebody() {
    Bytes prefix;
    for (int i = 0; i < 3; ++i) put(prefix, static_cast<std::uint32_t>(random_()));
    return prefix;
  }
  // Another router each time, with a lease of 100 s.
  Bytes participant() {
    const Bytes prefix = somebody();
    Bytes body;
    put(body, 16U << 16);                                 // offset to the inline QoS
    put(body, 0xC7000100);                                // reader: of participants
    put(body, 0xC2000100);                                // writer
    for (const std::uint32_t n : {0U, 1U}) put(body, n);  // sequence number
    put(body, 0x00000300);                                // parameter list, little endian
    put(body, 0x00040015), put(body, 0x00000302);         // protocol version
    put(body, 0x00040016), put(body, 0x00000F01);         // vendor
    put(body, 0x00100050);                                // its GUID
    body.insert(body.end(), prefix.begin(), prefix.end());
    put(body, 0xC1010000);
    put(body, 0x00080002), put(body, 100), put(body, 0);  // lease
    put(body, 0x00040058), put(body, 0x00000C3F);         // all built-in endpoints
    put(body, 0x2C | static_cast<std::uint32_t>(user_data_.size() + 4) << 16);
    put(body, user_data_size_);
    body.insert(body.end(), user_data_.begin(), user_data_.end());
    put(body, 1);
    return message(prefix, kData, body);
  }
  Bytes heartbeat() {
    Bytes body;
    for (int i = 0; i < 2; ++i) put(body, entity());
    for (const std::uint32_t n : {0U, 1U, 0x7FFFFFFFU, 0xFFFFFFFFU, ++count_}) put(body, n);
    return message(peer_, kHeartbeat, body);
  }
  // All that will ever be sent is said to be missing.
  Bytes gap() {
    Bytes body;
    for (int i = 0; i < 2; ++i) put(body, entity());
    for (const std::uint32_t n : {0U, 1U, 0U, 1'000'000'000U, 0U}) put(body, n);
    return message(peer_, kGap, body);
  }
  // All that was sent is said to have arrived.
  Bytes acknowledgement() {
    Bytes body;
    for (int i = 0; i < 2; ++i) put(body, entity());
    for (const std::uint32_t n : {0U, 1'000'000'000U, 0U, ++count_}) put(body, n);
    return message(peer_, kAcknowledgement, body);
  }
  Bytes fragment() {
    Bytes body;
    put(body, 28U << 16);
    for (int i = 0; i < 2; ++i) put(body, entity());
    for (const std::uint32_t n : {0U, 1U, 1U, 1U << 16 | 1024U, 1U << 30}) put(body, n);
    body.resize(body.size() + 64);
    return message(peer_, kDataFrag, body);
  }
  Bytes noise() {
    Bytes body(random_() % 300);
    for (std::uint8_t& byte : body) byte = static_cast<std::uint8_t>(random_());
    return message(somebody(), static_cast<Submessage>(random_() % 0x20), body);
  }
  // Readers and writers: any, those of discovery, and the first ones of users.
  std::uint32_t entity() {
    constexpr std::array<std::uint32_t, 9> kAll{0,          0xC7000100, 0xC2000100,
                                                0xC2030000, 0xC7040000, 0x03010000,
                                                0x04020000, 0x04010000, 0x03020000};
    return kAll[random_() % kAll.size()];
  }
  void send_to_all(const char* host, const Bytes& bytes) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    ::inet_pton(AF_INET, host, &to.sin_addr);
    for (const int port : {7400, 7410, 7411, 7412, 7413}) {
      to.sin_port = htons(static_cast<std::uint16_t>(port));
      (void)::sendto(socket_.get(), bytes.data(), bytes.size(), 0,
                     reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }
  }

  os::File socket_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  std::minstd_rand random_{1};
  Bytes user_data_;  // with its padding
  std::uint32_t user_data_size_ = 0;
  Bytes peer_;
  std::uint32_t count_ = 0;
};

}  // namespace tims::test
