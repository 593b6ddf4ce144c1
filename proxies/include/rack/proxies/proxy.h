// A proxy of a component: its methods send a command and wait for the answer.
//
//   rack::ChassisProxy chassis(work_mailbox, *tims::Address::parse("Chassis(0/0)"));
//   if (auto moved = chassis.move(200, 0, 0.1F); !moved) log(moved.error().message());
//
// A proxy sends from a *work mailbox*, which is for answers only: all other messages that arrive
// there during a call are discarded. Several proxies may share one, but only one may be called at a
// time. Its slots must have room for the largest answer (body_max<Data>()), else the answer cannot
// be delivered and the call ends with kTimeout. With 240 bytes or more, a component that refuses a
// command can add the reason (kReasonMax).
//
// Errors of every call, with the component and the command in their text:
//   kAnsweredError    the component answered ERROR, with its reason; or TIMEOUT
//   kTimeout          no answer in time
//   kNoMailbox        no mailbox has the address (NOT_AVAILABLE)
//   kMalformed        the answer is not valid
//   kInvalidArgument  the content of the request cannot be sent
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

#pragma GCC visibility push(default)  // exported by librack.so
namespace rack {

// Timeouts of a call as a whole.
struct ProxyTimeouts {
  tims::Duration on = std::chrono::seconds(5);
  tims::Duration off = std::chrono::seconds(1);
  tims::Duration file = std::chrono::seconds(30);        // commands that load or save a file
  tims::Duration data = std::chrono::milliseconds(100);  // everything else
};

enum class Verdict : u8;

class Proxy {
 public:
  // `work` must outlive the proxy.
  Proxy(tims::Mailbox& work, tims::Address component, const ProxyTimeouts& timeouts = {})
      : work_(&work), component_(component), timeouts_(timeouts) {}

  [[nodiscard]] tims::Address component() const { return component_; }
  [[nodiscard]] tims::AddressWidths address_widths() const { return work_->address_widths(); }

  Result<void> on();  // a data module answers when it has its first data
  Result<void> off();
  Result<Status> status();
  Result<ParameterList> get_param();
  // What the component states about itself, as JSON. Programs of the original answer ERROR.
  Result<std::string> describe();
  // One at a time, because the mailbox of an original module has no room for more.
  Result<void> set_param(const Parameter& parameter);

  // Subscribes `data_mailbox` to the data; returns the granted period. 0: as fast as possible.
  Result<Milliseconds<u32>> get_cont_data(Milliseconds<u32> period, tims::Address data_mailbox);
  Result<void> stop_cont_data(tims::Address data_mailbox);

  // The result of a command sent with post(), returned once: success, or the error. Nothing: the
  // answer has not arrived yet, or was taken. Does not wait.
  std::optional<Result<void>> take_answer();

 protected:
  // Returns the component's answer if it has one of the types in `answers`.
  Result<tims::PeekGuard> ask(i8 type, std::span<const i8> answers, tims::Duration timeout);
  template <Struct Body>
  Result<tims::PeekGuard> ask(i8 type, const Body& body, std::span<const i8> answers,
                              tims::Duration timeout);

  // Commands that are answered by OK.
  Result<void> command(i8 type) { return command(type, timeouts_.data); }
  Result<void> command(i8 type, tims::Duration timeout);
  template <Struct Body>
  Result<void> command(i8 type, const Body& body) {
    return command(type, body, timeouts_.data);
  }
  template <Struct Body>
  Result<void> command(i8 type, const Body& body, tims::Duration timeout);

  // Sends a command without waiting for its answer: see take_answer(). Until the answer has
  // arrived, do not make another call with this proxy, nor with another proxy on the same work
  // mailbox. A later post() replaces the pending command.
  template <Struct Body>
  Result<void> post(i8 type, const Body& body);

  // Requests that are answered by `Answer`, as a message of type `answer`.
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
  [[nodiscard]] tims::Duration file_timeout() const { return timeouts_.file; }

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
  u8 seq_nr_ = 0;  // of the newest request; identifies answers to earlier ones
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
Result<void> Proxy::command(i8 type, const Body& body, tims::Duration timeout) {
  static constexpr i8 kAnswers[] = {tims::type::kOk};
  const auto answer = ask(type, body, kAnswers, timeout);
  return answer ? Result<void>() : answer.error();
}

template <Struct Answer>
Result<void> Proxy::read(const Result<tims::PeekGuard>& message, Answer& answer) const {
  if (!message) return message.error();
  const auto good = decode({message->header(), message->body()}, answer);
  return good ? good : named(good.error(), message->header().type);
}

// --- Proxies of components that publish data, on request or as a stream.

// See below; declared here for structs of other namespaces.
template <Struct Data>
Result<void> decode_data(const tims::MessageView& message, tims::Address producer, Data& data,
                         const tims::AddressWidths& widths = {});

// ClassId: of these components; a rack::Partner derives their address from it.
template <Struct DataType, u32 ClassId = 0>
class DataProxy : public Proxy {
 public:
  using Data = DataType;
  static constexpr u32 kClassId = ClassId;
  using Proxy::Proxy;

  // The data recorded nearest to that time; 0: the newest.
  Result<void> get_data(Data& data, TimeStamp time = 0) {
    static constexpr i8 kAnswers[] = {tims::type::kData};
    return read(ask(tims::type::kGetData, GetDataRequest{time}, kAnswers, data_timeout()), data);
  }
  Result<Data> get_data(TimeStamp time = 0) {
    return filled([&](Data& data) { return get_data(data, time); });
  }

  // The next data set that is produced: `timeout` should be longer than the component's period.
  Result<void> get_next_data(Data& data, tims::Duration timeout) {
    static constexpr i8 kAnswers[] = {tims::type::kData};
    return read(ask(tims::type::kGetNextData, kAnswers, timeout), data);
  }
  Result<Data> get_next_data(tims::Duration timeout) {
    return filled([&](Data& data) { return get_next_data(data, timeout); });
  }
  Result<Data> get_next_data() { return get_next_data(data_timeout()); }

  // Decodes a message of the stream that get_cont_data() has subscribed to.
  Result<void> decode_stream(const tims::PeekGuard& message, Data& data) const {
    return decode_data({message.header(), message.body()}, component(), data, address_widths());
  }

 private:
  template <typename Fill>
  static Result<Data> filled(Fill fill) {
    Data data{};
    if (const auto good = fill(data); !good) return good.error();
    return data;
  }
};

// --- Matching of answers to a call: pure functions, so that every case can be tested.

struct Question {
  tims::Address component;      // the component that received the request
  u8 seq_nr = 0;                // of the request; repeated in the answer
  std::span<const i8> answers;  // types of valid answers
};

enum class Verdict : u8 {
  kUnrelated,  // from another sender, or the late answer to an earlier request
  kAnswer,
  kError,
  kTimeout,       // the component itself waited for another one without success
  kNotAvailable,  // no mailbox has the address; sent by the router
};

constexpr Verdict judge(const Question& question, const tims::Header& message) {
  if (message.src != question.component || message.seq_nr != question.seq_nr) {
    return Verdict::kUnrelated;
  }
  // Checked first: the answer to GET_STATUS may be ERROR.
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

// Checks whether this is data of `producer`:
//   kAnsweredError    the producer was turned off or failed, and has removed its listeners:
//                     subscribe again
//   kInvalidArgument  a message of another sender, or not data
Result<void> check_data(const tims::Header& header, tims::Address producer,
                        const tims::AddressWidths& widths = {});

// check_data(), then decodes the data (kMalformed). Allocates nothing when `data` has enough
// capacity.
template <Struct Data>
Result<void> decode_data(const tims::MessageView& message, tims::Address producer, Data& data,
                         const tims::AddressWidths& widths) {
  if (auto good = check_data(message.header, producer, widths); !good) return good;
  return decode(message, data);
}

}  // namespace rack

#pragma GCC visibility pop
