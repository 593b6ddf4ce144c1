// A partner (rack/partner.h) whose data stream a component receives.
//
//   Input<OdometryProxy> odometry_{*this, "odometry", work_, 4, wire_size<OdometryData>()};
//
//   module_on():    set_period(*odometry_.start())
//   module_loop():  odometry_.next(data, patience_with(period()))  // an error ends the loop;
//   retried later module_off():   odometry_.stop()
#pragma once

#include <algorithm>
#include <string>

#include "rack/clock.h"
#include "rack/partner.h"
#include "tims/origin.h"

namespace rack {

// How long to wait for data of this period. On a busy machine they come late; an error, and the
// restart after it, would lose more than the time.
inline tims::Duration patience_with(std::chrono::milliseconds period) {
  return std::max<tims::Duration>(5 * period, std::chrono::seconds(2));
}

template <typename ProxyType>
class Input : public Partner<ProxyType> {
 public:
  using Data = typename ProxyType::Data;

  // slots, body_max: of the mailbox of the stream.
  Input(Module& module, std::string_view name, const OwnMailbox& work, std::uint32_t slots,
        std::uint32_t body_max)
      : Partner<ProxyType>(module, name, work), stream_(module, slots, body_max) {}

  // Turns the producer on and subscribes; returns the granted period. If the partner is not named:
  // nothing, and 0.
  Result<std::chrono::milliseconds> start(std::chrono::milliseconds period = {}) {
    if (const auto on = this->turn_on(); !on) return on.error();
    return subscribe(period);
  }
  // After an error, the same with other timeouts, at the address of the last start().
  Result<std::chrono::milliseconds> start_again(const ProxyTimeouts& timeouts) {
    this->create_proxy((*this)->component(), timeouts);
    if (const auto on = (*this)->on(); !on) return on.error();
    return subscribe();
  }
  // The second step of start(), for callers that send a request to the producer before.
  Result<std::chrono::milliseconds> subscribe(std::chrono::milliseconds period = {}) {
    silence_ = 0;
    if (!*this) return std::chrono::milliseconds(0);
    stream_->clean();  // drops messages of an earlier stream
    const auto granted =
        (*this)->get_cont_data(static_cast<u32>(period.count()), stream_->address());
    if (!granted) return granted.error();
    return std::chrono::milliseconds(granted->raw());
  }
  // Also allowed when it was not started, or only in part.
  void stop() {
    if (*this) (void)(*this)->stop_cont_data(stream_->address());
    this->disconnect();
  }

  // Waits for a message. kTimeout: none from the producer; kAnsweredError: it was turned off or
  // failed.
  Result<void> next(Data& data, tims::Duration timeout) {
    const tims::Time end = now() + timeout;
    for (;;) {
      const auto left = std::max(end - now(), tims::Duration(0));
      const auto message = stream_->peek_for(left);
      if (!message) return named(message.error(), timeout);
      auto good = (*this)->decode_stream(*message, data);
      if (good || good.error().code() != tims::Errc::kInvalidArgument) return good;
    }
  }
  // The next received message; false: there is none.
  Result<bool> another(Data& data) {
    for (;;) {
      const auto message = stream_->try_peek();
      if (!message) {
        if (message.error().code() == tims::Errc::kEmpty) return false;
        return message.error();
      }
      const auto good = (*this)->decode_stream(*message, data);
      is_foreign_ = tims::is_foreign(message->header());
      if (good) return true;
      if (good.error().code() != tims::Errc::kInvalidArgument) return good.error();
    }
  }
  // The newest received message.
  Result<bool> newest(Data& data) {
    bool any = false;
    for (;;) {
      const auto come = another(data);
      if (!come) return come.error();
      if (!*come) return any;
      any = true;
    }
  }
  // The same, for polling: kTimeout when `looks` calls in a row found nothing.
  Result<bool> newest(Data& data, int looks) {
    auto come = newest(data);
    if (!come) return come;
    silence_ = *come ? 0 : silence_ + 1;
    if (silence_ >= looks)
      return tims::Error(tims::Errc::kTimeout, "no data from " + producer_name());
    return come;
  }
  // The last message of another() or newest() came over TCP, from a browser or from another host.
  [[nodiscard]] bool is_foreign() const { return is_foreign_; }
  // Number of calls in a row of the previous function without a message.
  [[nodiscard]] int silence() const { return silence_; }

 private:
  [[nodiscard]] tims::Error named(const tims::Error& error, tims::Duration waited) {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(waited).count();
    return {error.code(), "no data from " + producer_name() + " for " + std::to_string(ms) + " ms"};
  }
  [[nodiscard]] std::string producer_name() {
    return (*this)->component().to_string(stream_->address_widths());
  }

  OwnMailbox stream_;
  int silence_ = 0;
  bool is_foreign_ = false;
};

}  // namespace rack
