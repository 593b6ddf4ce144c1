// Pushes data of a different class than the driver's to the component that publishes them, to its
// mailbox with local id 1, as in the original.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rack/module.h"
#include "rack/proxies/proxy.h"

namespace rack::device {

template <class Data>
class Relay {
 public:
  // work: mailbox for commands to the component.
  void aim(tims::Mailbox& work, tims::Address component) {
    proxy_.emplace(work, component);
    to_ = tims::Address(component.raw() + 1);
  }
  void stop() { proxy_.reset(); }
  [[nodiscard]] bool is_aimed() const { return proxy_.has_value(); }
  Result<void> turn_on() { return proxy_ ? proxy_->on() : Result<void>(); }

  // If the component is not running, the data are lost.
  void send(tims::Mailbox& from, const Data& data) {
    if (!proxy_) return;
    bytes_.resize(encoded_size(data));
    if (!encode(data, bytes_).ok()) return;
    (void)from.send({.dest = to_, .type = tims::type::kData}, bytes_);
  }

 private:
  std::optional<Proxy> proxy_;
  tims::Address to_{};
  std::vector<std::byte> bytes_;
};

}  // namespace rack::device
