// UDP as the library does it, but for the user traffic: that comes and goes by a socket of ours.
#pragma once

#include <memory>

#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>

#include "router/io/dds/user_traffic.h"

namespace tims::io {

struct DdsTransport final : eprosima::fastdds::rtps::ChainingTransportDescriptor {
  using Udp = std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface>;

  DdsTransport(Udp udp, std::shared_ptr<UserTraffic> user_traffic)
      : ChainingTransportDescriptor(std::move(udp)), traffic(std::move(user_traffic)) {}
  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override;

  std::shared_ptr<UserTraffic> traffic;
};

}  // namespace tims::io
