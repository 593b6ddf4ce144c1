// Partners: the other components that a component needs. A partner is declared as one row of the
// parameters, by which users select it, and as one member, by which the component uses it.
//
//   constexpr std::array<ParameterInfo, 2> kParameters = {{
//       required_partner("ladar", "the ladar"),                         // ladarSys, ladarInst
//       optional_partner("position", "the position", "the position; -1: none"),
//   }};
//
//   OwnMailbox work_{*this, 1, body_max<PositionData>()};               // for answers
//   Partner<PositionProxy> position_{*this, "position", work_};
//   Input<LadarProxy> ladar_{*this, "ladar", work_, 2, body_max<LadarData>()};  // rack/input.h
//
//   module_on():    if (auto on = position_.turn_on(); !on) return on;
//   module_loop():  if (position_) { const auto pose = position_->get_data(); ... }
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "rack/module.h"
#include "rack/proxies/proxy.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

// The part that does not depend on the proxy.
class PartnerBase {
 public:
  // The address by its parameters. Nothing: its instance is below 0, the component works without
  // it.
  [[nodiscard]] std::optional<tims::Address> address() const;
  [[nodiscard]] bool is_named() const { return address().has_value(); }

 protected:
  // name: of its row of the parameters. work: receives answers; may be shared by the partners of
  // one thread.
  PartnerBase(Module& module, std::uint32_t class_id, std::string_view name,
              const OwnMailbox& work);
  [[nodiscard]] tims::Mailbox& work() const { return **work_; }

 private:
  const Module* module_;
  const OwnMailbox* work_;
  std::uint32_t class_id_;
  std::string system_;  // the names of its parameters
  std::string instance_;
};

// One thread. The proxy exists from connect() or turn_on() until disconnect(), if the partner is
// named.
template <typename ProxyType>
class Partner : public PartnerBase {
  static_assert(ProxyType::kClassId != 0, "its proxy must be a DataProxy<Data, CLASS_ID>");

 public:
  // timeouts: replace the defaults of the proxy.
  Partner(Module& module, std::string_view name, const OwnMailbox& work,
          std::optional<ProxyTimeouts> timeouts = {})
      : PartnerBase(module, ProxyType::kClassId, name, work), timeouts_(timeouts) {}

  [[nodiscard]] explicit operator bool() const { return proxy_.has_value(); }
  // Only while there is a proxy.
  [[nodiscard]] ProxyType* operator->() { return &*proxy_; }
  [[nodiscard]] ProxyType& operator*() { return *proxy_; }

  // Creates the proxy by the current parameters, without a message.
  void connect() {
    proxy_.reset();
    if (const auto component = address()) create_proxy(*component, timeouts_);
  }
  void disconnect() { proxy_.reset(); }
  // connect(), and turns the component on. Success also if the partner is not named.
  Result<void> turn_on() {
    connect();
    return proxy_ ? proxy_->on() : Result<void>();
  }

 protected:
  void create_proxy(tims::Address component, const std::optional<ProxyTimeouts>& timeouts) {
    if (timeouts) {
      proxy_.emplace(work(), component, *timeouts);
    } else {
      proxy_.emplace(work(), component);
    }
  }

 private:
  std::optional<ProxyTimeouts> timeouts_;
  std::optional<ProxyType> proxy_;
};

}  // namespace rack

#pragma GCC visibility pop
