// A data stream from another component that this one depends on.
//
//   module_init():  create_input(input_, *work_, slots, body_max)  // creates the stream's mailbox
//   module_on():    set_period(*input_->start(odometry))
//   module_loop():  input_->next(data, 5 * period())    // an error ends the loop; retried later
//   later module_off():   input_->stop()
//
// One thread; the work mailbox may be shared with other proxies of that thread.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "rack/clock.h"
#include "rack/proxies/proxy.h"

namespace rack {

template <typename ProxyType>
class Input {
 public:
  using Data = typename ProxyType::Data;

  Input(tims::Mailbox& work, tims::Mailbox& stream) : work_(&work), stream_(&stream) {}

  [[nodiscard]] bool started() const { return proxy_.has_value(); }
  // Only while it is started.
  [[nodiscard]] ProxyType& proxy() { return *proxy_; }

  // Turns the producer on and subscribes; returns the granted period. timeouts: ProxyTimeouts, to
  // replace the defaults of the proxy.
  Result<std::chrono::milliseconds> start(tims::Address producer,
                                          std::chrono::milliseconds period = {},
                                          const auto&... timeouts) {
    if (const auto on = turn_on(producer, timeouts...); !on) return on.error();
    return subscribe(period);
  }
  // The two steps of start(), for callers that send a request to the producer in between.
  Result<void> turn_on(tims::Address producer, const auto&... timeouts) {
    proxy_.emplace(*work_, producer, timeouts...);
    return proxy_->on();
  }
  Result<std::chrono::milliseconds> subscribe(std::chrono::milliseconds period = {}) {
    stream_->clean();  // drops messages of an earlier stream
    silence_ = 0;
    const auto granted =
        proxy_->get_cont_data(static_cast<u32>(period.count()), stream_->address());
    if (!granted) return granted.error();
    return std::chrono::milliseconds(granted->raw());
  }
  // Also allowed when it was not started, or only in part.
  void stop() {
    if (proxy_) (void)proxy_->stop_cont_data(stream_->address());
    proxy_.reset();
  }

  // Waits for a message. kTimeout: none from the producer; kAnsweredError: it was turned off or
  // failed.
  Result<void> next(Data& data, tims::Duration timeout) {
    const tims::Time end = now() + timeout;
    for (;;) {
      const auto left = std::max(end - now(), tims::Duration(0));
      const auto message = stream_->peek_for(left);
      if (!message) return named(message.error(), timeout);
      auto good = proxy_->decode_stream(*message, data);
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
      const auto good = proxy_->decode_stream(*message, data);
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
  // Number of calls in a row of the previous function without a message.
  [[nodiscard]] int silence() const { return silence_; }

 private:
  [[nodiscard]] tims::Error named(const tims::Error& error, tims::Duration waited) const {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(waited).count();
    return {error.code(), "no data from " + producer_name() + " for " + std::to_string(ms) + " ms"};
  }
  [[nodiscard]] std::string producer_name() const {
    return proxy_->component().to_string(work_->address_widths());
  }

  tims::Mailbox* work_;
  tims::Mailbox* stream_;
  std::optional<ProxyType> proxy_;
  int silence_ = 0;
};

}  // namespace rack
