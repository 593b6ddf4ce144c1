// Our link on one host: one mailbox per process, messages directly into the receiver's.
#pragma once

#include <cstring>
#include <vector>

#include "libtims/os/clock.h"
#include "tests/bench/addresses.h"
#include "tests/bench/link.h"
#include "tests/bench/message.h"
#include "tests/bench/plan.h"
#include "tims/session.h"

namespace tims::bench {

class TimsLink {
 public:
  enum class Method {
    kCopy,  // send + peek
    kLoan,  // loan + peek: only the head of the message is written, in place
  };

  static Result<TimsLink> open(const Plan& plan, Method method) {
    SessionOptions options{.name = "bench-" + plan.role, .router = plan.socket};
    options.timeout = std::chrono::seconds(5);
    auto session = Session::connect(std::move(options));
    if (!session) return session.error();
    auto mailbox = session->open(mailbox_of(plan));
    if (!mailbox) return mailbox.error();
    return TimsLink(plan, method, std::move(*session), std::move(*mailbox));
  }

  bool send(std::span<const std::byte> message) {
    for (const Address receiver : others_) {
      const Envelope envelope{.dest = receiver, .type = type::kData};
      if (method_ == Method::kCopy) {
        if (!mailbox_.send(envelope, message)) return false;
      } else if (!send_in_place(envelope, message)) {
        return false;
      }
    }
    return true;
  }
  void flush() {}

  template <typename Deliver>
  void receive(Duration timeout, Deliver deliver) {
    if (streaming_ && take_all(deliver)) return;
    if (auto message = mailbox_.peek_for(timeout)) deliver(message->body());
  }
  [[nodiscard]] bool needs_credit() const { return true; }

 private:
  static MailboxOptions mailbox_of(const Plan& plan) {
    constexpr std::uint64_t kMargin = 4;    // messages before and after the data
    constexpr std::uint64_t kAnswers = 64;  // of eight subscribers, with a margin
    const bool takes_data = plan.role != "source";
    const std::uint64_t slots = takes_data ? slots_of(plan) + kMargin : kAnswers;
    const std::size_t body_max = takes_data ? std::max(plan.payload, kReplyBytes) : kReplyBytes;
    return {.address =
                plan.sender() ? sender_address(plan.pair) : receiver_address(plan.pair, plan.index),
            .slots = static_cast<std::uint32_t>(slots),
            .body_max = static_cast<std::uint32_t>(body_max),
            .priority = static_cast<std::uint8_t>(plan.priority),
            .spin = plan.streaming() ? kStreamSpin : Duration::zero()};
  }

  TimsLink(const Plan& plan, Method method, Session session, Mailbox mailbox)
      : method_(method),
        streaming_(plan.streaming()),
        session_(std::move(session)),
        mailbox_(std::move(mailbox)) {
    if (!plan.sender()) {
      others_.push_back(sender_address(plan.pair));
    } else {
      for (std::uint32_t i = 0; i < plan.subscribers; ++i)
        others_.push_back(receiver_address(plan.pair, i));
    }
  }

  bool send_in_place(const Envelope& envelope, std::span<const std::byte> message) {
    auto loan = mailbox_.loan(envelope, static_cast<std::uint32_t>(message.size()));
    if (!loan) return false;
    std::memcpy(loan->body().data(), message.data(), sizeof(Head));
    return loan->send().ok();
  }

  template <typename Deliver>
  bool take_all(Deliver& deliver) {
    bool any = false;
    while (auto message = mailbox_.try_peek()) {
      deliver(message->body());
      any = true;
    }
    return any;
  }

  Method method_;
  bool streaming_;
  Session session_;
  Mailbox mailbox_;
  std::vector<Address> others_;
};

}  // namespace tims::bench
