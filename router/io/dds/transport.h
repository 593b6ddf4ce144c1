// UDP as the library does it, but for the user traffic, which comes and goes by a socket of ours,
// and for discovery, of which the library gets what it needs.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>

#include "router/io/dds/metatraffic.h"
#include "router/io/dds/user_traffic.h"

namespace tims::io {

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
