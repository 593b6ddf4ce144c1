// Forged datagrams of DDS (RTPS 2.3), as everybody on the network can send them.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "os/file.h"

namespace tims::test {

class RtpsStorm {
 public:
  // Sends so many datagrams of each kind to the first participants of a host.
  static void send(const char* host, int each) {
    RtpsStorm storm;
    for (int i = 0; i < each; ++i) {
      for (const auto& message :
           {storm.participant(), storm.heartbeat(), storm.gap(), storm.fragment(), storm.noise()})
        for (const int port : {7400, 7410, 7411, 7412, 7413}) storm.send(host, port, message);
    }
  }

 private:
  using Bytes = std::vector<std::uint8_t>;
  enum Submessage : std::uint8_t { kGap = 0x08, kHeartbeat = 0x07, kData = 0x15, kDataFrag = 0x16 };

  static void put(Bytes& out, std::uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8)
      out.push_back(static_cast<std::uint8_t>(value >> shift));
  }
  // Of another participant each time: little endian, vendor eProsima.
  Bytes message(Submessage kind, const Bytes& body) {
    Bytes out{'R', 'T', 'P', 'S', 2, 3, 1, 0x0F};
    prefix_ = {static_cast<std::uint32_t>(random_()), static_cast<std::uint32_t>(random_()),
               static_cast<std::uint32_t>(random_())};
    for (const std::uint32_t part : prefix_) put(out, part);
    out.insert(out.end(), {kind, static_cast<std::uint8_t>(kind == kData ? 5 : 1),
                           static_cast<std::uint8_t>(body.size() & 0xFF),
                           static_cast<std::uint8_t>(body.size() >> 8)});
    out.insert(out.end(), body.begin(), body.end());
    return out;
  }
  // It announces itself with a lease of 100 s.
  Bytes participant() {
    Bytes body;
    put(body, 16U << 16);                                 // offset to the inline QoS
    put(body, 0xC7000100);                                // reader: of participants
    put(body, 0xC2000100);                                // writer
    for (const std::uint32_t n : {0U, 1U}) put(body, n);  // sequence number
    put(body, 0x00000300);                                // parameter list, little endian
    put(body, 0x00040015), put(body, 0x00000302);         // protocol version
    put(body, 0x00040016), put(body, 0x00000F01);         // vendor
    put(body, 0x00100050);                                // its GUID
    for (const std::uint32_t part : prefix_) put(body, part);
    put(body, 0xC1010000);
    put(body, 0x00080002), put(body, 100), put(body, 0);  // lease
    put(body, 0x00040058), put(body, 0x00000C3F);         // all built-in endpoints
    put(body, 1);
    return message(kData, body);
  }
  Bytes heartbeat() {
    Bytes body;
    for (int i = 0; i < 2; ++i) put(body, entity());
    for (const std::uint32_t n : {0U, 1U, 0x7FFFFFFFU, 0xFFFFFFFFU, ++count_}) put(body, n);
    return message(kHeartbeat, body);
  }
  Bytes gap() {
    Bytes body;
    for (int i = 0; i < 2; ++i) put(body, entity());
    for (const std::uint32_t n : {0U, 1U, 0x7FFFFFFFU, 0xFFFFFFFFU, 0U}) put(body, n);
    return message(kGap, body);
  }
  Bytes fragment() {
    Bytes body;
    put(body, 28U << 16);
    for (int i = 0; i < 2; ++i) put(body, entity());
    for (const std::uint32_t n : {0U, 1U, 1U, 1U << 16 | 1024U, 1U << 30}) put(body, n);
    body.resize(body.size() + 64);
    return message(kDataFrag, body);
  }
  Bytes noise() {
    Bytes body(random_() % 300);
    for (std::uint8_t& byte : body) byte = static_cast<std::uint8_t>(random_());
    return message(static_cast<Submessage>(random_() % 0x20), body);
  }
  // Readers and writers: those of discovery, and the first ones of users.
  std::uint32_t entity() {
    constexpr std::array<std::uint32_t, 6> kAll{0xC7000100, 0xC2000100, 0xC2030000,
                                                0xC7040000, 0x03010000, 0x04020000};
    return kAll[random_() % kAll.size()];
  }
  void send(const char* host, int port, const Bytes& bytes) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, host, &to.sin_addr);
    (void)::sendto(socket_.get(), bytes.data(), bytes.size(), 0,
                   reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }

  os::File socket_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  std::minstd_rand random_{1};
  std::array<std::uint32_t, 3> prefix_{};
  std::uint32_t count_ = 0;
};

}  // namespace tims::test
