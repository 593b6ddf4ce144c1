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

#include <algorithm>
#include <chrono>
#include <optional>
#include <span>

#include "rack/codec/codec.h"
#include "rack/codec/quantity.h"
#include "rack/proxies/generic.h"
#include "tims/address.h"
#include "tims/mailbox.h"
#include "tims/message.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

// How long a call waits, all in all.
struct ProxyTimeouts {
  tims::Duration on = std::chrono::seconds(5);
  tims::Duration off = std::chrono::seconds(1);
  tims::Duration data = std::chrono::milliseconds(100);  // everything else
};

enum class Verdict : u8;

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

  // Of a command that was posted, once: that it was done, or why not. Nothing: the answer is on its
  // way still, or was taken. Does not wait.
  std::optional<Result<void>> take_answer();

 protected:
  // The component's answer, of one of the types in `answers`.
  Result<tims::PeekGuard> ask(i8 type, std::span<const i8> answers, tims::Duration timeout);
  template <Struct Body>
  Result<tims::PeekGuard> ask(i8 type, const Body& body, std::span<const i8> answers,
                              tims::Duration timeout);

  // Answered by OK.
  Result<void> command(i8 type) { return command(type, timeouts_.data); }
  Result<void> command(i8 type, tims::Duration timeout);
  template <Struct Body>
  Result<void> command(i8 type, const Body& body);

  // The same for who may not wait: take_answer(). Until that has come the proxy is not called
  // otherwise, and no other one has its work mailbox; a command that is posted later takes its
  // place.
  template <Struct Body>
  Result<void> post(i8 type, const Body& body);

  // Answered by `Answer`, as a message of type `answer`.
  template <Struct Answer>
  Result<Answer> query(i8 type, i8 answer) {
    return query<Answer>(type, answer, timeouts_.data);
  }
  template <Struct Answer>
  Result<Answer> query(i8 type, i8 answer, tims::Duration timeout) {
    return read<Answer>(ask(type, {&answer, 1}, timeout));
  }
  template <Struct Answer, Struct Body>
  Result<Answer> query(i8 type, const Body& body, i8 answer) {
    return read<Answer>(ask(type, body, {&answer, 1}, timeouts_.data));
  }

  template <Struct Answer>
  Result<void> read(const Result<tims::PeekGuard>& message, Answer& answer) const;
  template <Struct Answer>
  Result<Answer> read(const Result<tims::PeekGuard>& message) const {
    Answer answer{};
    if (const auto good = read(message, answer); !good) return good.error();
    return answer;
  }

  [[nodiscard]] tims::Duration data_timeout() const { return timeouts_.data; }

 private:
  struct Request {
    i8 type = 0;
    std::size_t body_size = 0;
  };
  struct Posted {
    i8 type = 0;
    tims::Time deadline{};
  };
  // A request under construction in the component's own mailbox.
  Result<tims::Loan> begin(Request request);
  template <Struct Body>
  Result<tims::Loan> begin(i8 type, const Body& body);
  Result<void> post(Result<tims::Loan> loan, i8 type);
  Result<tims::PeekGuard> finish(Result<tims::Loan> loan, i8 type, std::span<const i8> answers,
                                 tims::Duration timeout);
  Result<void> send(Result<tims::Loan> loan, i8 type) const;
  [[nodiscard]] tims::Error refusal(const tims::PeekGuard& message, Verdict verdict, i8 type) const;
  [[nodiscard]] tims::Error named(const tims::Error& error, i8 type) const;

  tims::Mailbox* work_;
  tims::Address component_;
  ProxyTimeouts timeouts_;
  u8 seq_nr_ = 0;  // of the newest request: answers to earlier ones are told by it
  std::optional<Posted> posted_;
};

// --- templates

template <Struct Body>
Result<tims::Loan> Proxy::begin(i8 type, const Body& body) {
  if (const auto good = codec::check(body); !good) return good.error();
  Result<tims::Loan> loan = begin({type, encoded_size(body)});
  if (loan) (void)encode(body, loan->body());  // checked above, and the slot is large enough
  return loan;
}

template <Struct Body>
Result<tims::PeekGuard> Proxy::ask(i8 type, const Body& body, std::span<const i8> answers,
                                   tims::Duration timeout) {
  return finish(begin(type, body), type, answers, timeout);
}

template <Struct Body>
Result<void> Proxy::post(i8 type, const Body& body) {
  return post(begin(type, body), type);
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

// --- Proxies of components that produce data: asked for, or as a stream.

template <Struct DataType>
class DataProxy : public Proxy {
 public:
  using Data = DataType;
  using Proxy::Proxy;

  // The data of that time, as near as there is; 0: the newest.
  Result<void> get_data(Data& data, TimeStamp time = 0) {
    static constexpr i8 kAnswers[] = {tims::type::kData};
    return read(ask(tims::type::kGetData, GetDataRequest{time}, kAnswers, data_timeout()), data);
  }
  Result<Data> get_data(TimeStamp time = 0) {
    return filled([&](Data& data) { return get_data(data, time); });
  }

  // The next that will be produced: `timeout` should be longer than the component's period.
  Result<void> get_next_data(Data& data, tims::Duration timeout) {
    static constexpr i8 kAnswers[] = {tims::type::kData};
    return read(ask(tims::type::kGetNextData, kAnswers, timeout), data);
  }
  Result<Data> get_next_data(tims::Duration timeout) {
    return filled([&](Data& data) { return get_next_data(data, timeout); });
  }
  Result<Data> get_next_data() { return get_next_data(data_timeout()); }

  // A message of the stream that get_cont_data() has asked for: see stream.h.
  Result<void> decode_stream(const tims::PeekGuard& message, Data& data) const {
    return decode_data({message.header(), message.body()}, component(), data);
  }

 private:
  template <typename Fill>
  static Result<Data> filled(Fill fill) {
    Data data{};
    if (const auto good = fill(data); !good) return good.error();
    return data;
  }
};

// --- Which message is the answer a call waits for: pure, so that every case can be tested.

struct Question {
  tims::Address component;      // who was asked
  u8 seq_nr = 0;                // of the request; everybody sends it back
  std::span<const i8> answers;  // types of good answers
};

enum class Verdict : u8 {
  kUnrelated,  // from somebody else, or late: the answer to an earlier request
  kAnswer,
  kError,
  kTimeout,       // the component itself waited in vain
  kNotAvailable,  // nobody owns the address; the router says so
};

constexpr Verdict judge(const Question& question, const tims::Header& message) {
  if (message.src != question.component || message.seq_nr != question.seq_nr) {
    return Verdict::kUnrelated;
  }
  // First: the answer to GET_STATUS may be ERROR.
  if (std::ranges::find(question.answers, message.type) != question.answers.end()) {
    return Verdict::kAnswer;
  }
  switch (message.type) {
    case tims::type::kError:
      return Verdict::kError;
    case tims::type::kTimeout:
      return Verdict::kTimeout;
    case tims::type::kNotAvailable:
      return Verdict::kNotAvailable;
    default:
      return Verdict::kUnrelated;
  }
}

// --- Messages of a data stream, as they arrive in the data mailbox.

// Whether this is data of `producer`, and if not, why:
//   kAnsweredError    the producer went off or failed, and has forgotten its listeners: ask again
//   kInvalidArgument  a message of somebody else, or no data
Result<void> check_data(const tims::Header& header, tims::Address producer);

// check_data(), and the data itself (kMalformed). Allocates nothing when `data` has the room.
template <Struct Data>
Result<void> decode_data(const tims::MessageView& message, tims::Address producer, Data& data) {
  if (auto good = check_data(message.header, producer); !good) return good;
  return decode(message, data);
}

}  // namespace rack

#pragma GCC visibility pop
