// Pushes data of a different class than the driver's to the component that publishes them, to its
// mailbox with local id 1, as in the original:
//
//   Relay<ClockProxy> relay_{*this, "clockRelay", work_};
#pragma once

#include <vector>

#include "rack/partner.h"

namespace rack::device {

template <class ProxyType>
class Relay : public Partner<ProxyType> {
 public:
  using Partner<ProxyType>::Partner;

  // If the component is not running, the data are lost.
  void send(const typename ProxyType::Data& data) {
    if (!*this) return;
    bytes_.resize(encoded_size(data));
    if (!encode(data, bytes_).ok()) return;
    const tims::Address to((*this)->component().raw() + 1);
    (void)this->work().send({.dest = to, .type = tims::type::kData}, bytes_);
  }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace rack::device
