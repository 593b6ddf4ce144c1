// A component as its users see it: calls that send a command and wait for the answer.
//
//   rack::ChassisProxy chassis(work_mailbox, *tims::Address::parse("Chassis(0/0)"));
//   if (auto moved = chassis.move(200, 0, 0.1F); !moved) log(moved.error().message());
//
// A proxy sends from a *work mailbox*, which is for answers only: whatever else arrives there
// during a call is thrown away. Several proxies may share one, but only one may be called at a
// time. It needs slots as large as the largest answer (body_max<Data>()), else the answer cannot be
// delivered and the call ends with kTimeout. With 240 bytes or more, who refuses a command can say
// why (kReasonMax).
//
// Errors of every call, with the component and the command in their text:
//   kAnsweredError    the component answered ERROR, with its reason; or TIMEOUT
//   kTimeout          no answer in time
//   kNoMailbox        nobody owns the address (NOT_AVAILABLE)
//   kMalformed        the answer is not what it should be
//   kInvalidArgument  the request cannot be sent as it is
//   others            of Mailbox::loan: the request could not be sent
#pragma once

#include <chrono>
#include <span>

#include "proxies/codec/codec.h"
#include "proxies/generic.h"
#include "tims/mailbox.h"

namespace rack {

// How long a call waits, all in all.
struct ProxyTimeouts {
  tims::Duration on = std::chrono::seconds(5);
  tims::Duration off = std::chrono::seconds(1);
  tims::Duration data = std::chrono::milliseconds(100);  // everything else
};

class Proxy {
 public:
  // `work` must outlive the proxy.
  Proxy(tims::Mailbox& work, tims::Address component, const ProxyTimeouts& timeouts = {})
      : work_(&work), component_(component), timeouts_(timeouts) {}

  [[nodiscard]] tims::Address component() const { return component_; }

  Result<void> on();  // a data module answers when it has data
  Result<void> off();
  Result<Status> status();
  Result<ParameterList> get_param();
  // One at a time: more do not fit into the mailbox of an original module.
  Result<void> set_param(const Parameter& parameter);

  // Asks for a stream to `data_mailbox`; returns the period granted. 0: as fast as possible.
  Result<Milliseconds<u32>> get_cont_data(Milliseconds<u32> period, tims::Address data_mailbox);
  Result<void> stop_cont_data(tims::Address data_mailbox);

 protected:
  // The component's answer, of one of the types in `answers`.
  Result<tims::PeekGuard> ask(i8 type, std::span<const i8> answers, tims::Duration timeout);
  template <Struct Body>
  Result<tims::PeekGuard> ask(i8 type, const Body& body, std::span<const i8> answers,
                              tims::Duration timeout);

  // Answered by OK.
  Result<void> command(i8 type);
  template <Struct Body>
  Result<void> command(i8 type, const Body& body);

  // Answered by `Answer`, as a message of type `answer`.
  template <Struct Answer>
  Result<Answer> query(i8 type, i8 answer);
  template <Struct Answer>
  Result<Answer> query(i8 type, i8 answer, tims::Duration timeout);
  template <Struct Answer, Struct Body>
  Result<Answer> query(i8 type, const Body& body, i8 answer);

  template <Struct Answer>
  Result<void> read(const Result<tims::PeekGuard>& message, Answer& answer) const;

  [[nodiscard]] tims::Duration data_timeout() const { return timeouts_.data; }

 private:
  struct Request {
    i8 type = 0;
    std::size_t body_size = 0;
  };
  // A request under construction in the component's own mailbox.
  Result<tims::Loan> begin(Request request);
  Result<tims::PeekGuard> finish(Result<tims::Loan> loan, i8 type, std::span<const i8> answers,
                                 tims::Duration timeout);
  [[nodiscard]] tims::Error named(const tims::Error& error, i8 type) const;

  tims::Mailbox* work_;
  tims::Address component_;
  ProxyTimeouts timeouts_;
  u8 seq_nr_ = 0;  // of the newest request: answers to earlier ones are told by it
};

// --- templates

template <Struct Body>
Result<tims::PeekGuard> Proxy::ask(i8 type, const Body& body, std::span<const i8> answers,
                                   tims::Duration timeout) {
  if (const auto good = codec::check(body); !good) return named(good.error(), type);
  Result<tims::Loan> loan = begin({type, encoded_size(body)});
  if (loan) (void)encode(body, loan->body());  // checked above, and the slot is large enough
  return finish(std::move(loan), type, answers, timeout);
}

template <Struct Body>
Result<void> Proxy::command(i8 type, const Body& body) {
  static constexpr i8 kAnswers[] = {tims::type::kOk};
  const auto answer = ask(type, body, kAnswers, timeouts_.data);
  return answer ? Result<void>() : answer.error();
}

template <Struct Answer>
Result<void> Proxy::read(const Result<tims::PeekGuard>& message, Answer& answer) const {
  if (!message) return message.error();
  const auto good = decode({message->header(), message->body()}, answer);
  return good ? good : named(good.error(), message->header().type);
}

template <Struct Answer>
Result<Answer> Proxy::query(i8 type, i8 answer) {
  return query<Answer>(type, answer, timeouts_.data);
}

template <Struct Answer>
Result<Answer> Proxy::query(i8 type, i8 answer, tims::Duration timeout) {
  Answer value{};
  const auto good = read(ask(type, {&answer, 1}, timeout), value);
  if (!good) return good.error();
  return value;
}

template <Struct Answer, Struct Body>
Result<Answer> Proxy::query(i8 type, const Body& body, i8 answer) {
  Answer value{};
  const auto good = read(ask(type, body, {&answer, 1}, timeouts_.data), value);
  if (!good) return good.error();
  return value;
}

}  // namespace rack
