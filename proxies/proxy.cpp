#include "rack/proxies/proxy.h"

#include <algorithm>
#include <string>
#include <utility>

#include "os/clock.h"
#include "rack/proxies/catalogue.h"

namespace rack {

namespace {

using tims::Errc;
using tims::Error;

constexpr i8 kOk[] = {tims::type::kOk};

Error error_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNotAvailable:
      return {Errc::kNoMailbox, "is it running, and is there a route to it?"};
    case Verdict::kTimeout:
      return {Errc::kAnsweredError, "it waited for another component, which did not answer"};
    default:
      return {Errc::kAnsweredError, "see its log texts for the reason"};
  }
}

Result<void> without_body(const Result<tims::PeekGuard>& answer) {
  return answer ? Result<void>() : answer.error();
}

}  // namespace

Result<void> Proxy::on() {
  return without_body(ask(tims::type::kOn, OnRequest{}, kOk, timeouts_.on));
}

Result<void> Proxy::off() { return without_body(ask(tims::type::kOff, kOk, timeouts_.off)); }

Result<Status> Proxy::status() {
  static constexpr i8 kAnswers[] = {tims::type::kEnabled, tims::type::kDisabled,
                                    tims::type::kError};
  const auto answer = ask(tims::type::kGetStatus, kAnswers, timeouts_.data);
  if (!answer) return answer.error();
  return static_cast<Status>(answer->header().type);
}

Result<ParameterList> Proxy::get_param() {
  return query<ParameterList>(tims::type::kGetParam, tims::type::kParam);
}

Result<std::string> Proxy::describe() {
  std::string description;
  for (bool more = true; more;) {
    const DescriptionRequest request{.offset = static_cast<i32>(description.size())};
    const auto page =
        query<DescriptionPage>(tims::type::kGetDescription, request, tims::type::kDescription);
    if (!page) return page.error();
    const auto appended = append_page(description, *page);
    if (!appended) return appended.error();
    more = *appended;
  }
  return description;
}

Result<void> Proxy::set_param(const Parameter& parameter) {
  ParameterList list;
  list.parameters.push_back(parameter);
  return command(tims::type::kSetParam, list);
}

Result<Milliseconds<u32>> Proxy::get_cont_data(Milliseconds<u32> period,
                                               tims::Address data_mailbox) {
  const auto granted = query<ContDataReply>(
      tims::type::kGetContData, GetContDataRequest{period, data_mailbox}, tims::type::kContData);
  if (!granted) return granted.error();
  return granted->periodTime;
}

Result<void> Proxy::stop_cont_data(tims::Address data_mailbox) {
  return command(tims::type::kStopContData, StopContDataRequest{data_mailbox});
}

Result<void> Proxy::command(i8 type, tims::Duration timeout) {
  return without_body(ask(type, kOk, timeout));
}

Result<tims::PeekGuard> Proxy::ask(i8 type, std::span<const i8> answers, tims::Duration timeout) {
  return finish(begin({type, 0}), type, answers, timeout);
}

Result<tims::Loan> Proxy::begin(Request request) {
  ++seq_nr_;
  return work_->loan({.dest = component_,
                      .type = request.type,
                      .seq_nr = seq_nr_,
                      .report_reason = work_->body_max() >= kReasonMax},
                     static_cast<u32>(request.body_size));
}

// One deadline for the whole call, independent of other messages that arrive.
Result<tims::PeekGuard> Proxy::finish(Result<tims::Loan> loan, i8 type, std::span<const i8> answers,
                                      tims::Duration timeout) {
  if (auto sent = send(std::move(loan), type); !sent) return sent.error();
  const Question question{component_, seq_nr_, answers};
  const tims::Time deadline = tims::os::deadline_after(timeout);
  for (;;) {
    const tims::Duration left = std::max(deadline - tims::os::now(), tims::Duration::zero());
    auto message = work_->peek_for(left);
    if (!message) return named(message.error(), type);
    const Verdict verdict = judge(question, message->header());
    if (verdict == Verdict::kAnswer) return message;
    if (verdict != Verdict::kUnrelated) return refusal(*message, verdict, type);
  }
}

Result<void> Proxy::send(Result<tims::Loan> loan, i8 type) const {
  if (!loan) return named(loan.error(), type);
  if (const auto sent = loan->send(); !sent) return named(sent.error(), type);
  return {};
}

Result<void> Proxy::post(Result<tims::Loan> loan, i8 type) {
  posted_.reset();
  if (auto sent = send(std::move(loan), type); !sent) return sent;
  posted_ = {.type = type, .deadline = tims::os::deadline_after(timeouts_.data)};
  return {};
}

std::optional<Result<void>> Proxy::take_answer() {
  if (!posted_) return {};
  const i8 type = posted_->type;
  for (;;) {
    const auto message = work_->try_peek();
    if (!message) break;
    const Verdict verdict = judge({component_, seq_nr_, kOk}, message->header());
    if (verdict == Verdict::kUnrelated) continue;
    posted_.reset();
    if (verdict == Verdict::kAnswer) return Result<void>();
    return Result<void>(refusal(*message, verdict, type));
  }
  if (tims::os::now() < posted_->deadline) return {};
  posted_.reset();
  return Result<void>(named(Error(Errc::kTimeout, ""), type));
}

Error Proxy::refusal(const tims::PeekGuard& message, Verdict verdict, i8 type) const {
  const std::string_view reason =
      verdict == Verdict::kError ? reason_of(message.body()) : std::string_view();
  return named(
      reason.empty() ? error_of(verdict) : Error(Errc::kAnsweredError, std::string(reason)), type);
}

// "Chassis(0/0), MOVE: ..."
Error Proxy::named(const Error& error, i8 type) const {
  const tims::AddressWidths widths = work_->address_widths();
  const MessageInfo* info = find_message(component_.fields(widths).class_id, type);
  std::string detail = component_.to_string(widths) + ", " +
                       (info != nullptr ? std::string(info->name) : "type " + std::to_string(type));
  if (!error.detail().empty()) detail.append(": ").append(error.detail());
  return {error.code(), std::move(detail)};
}

Result<void> check_data(const tims::Header& header, tims::Address producer,
                        const tims::AddressWidths& widths) {
  using tims::Errc;
  using tims::Error;
  if (header.src != producer) {
    return Error(Errc::kInvalidArgument, "a message of " + header.src.to_string(widths) +
                                             " in the stream of " + producer.to_string(widths) +
                                             ": open a data mailbox for each producer");
  }
  if (header.type == tims::type::kError) {
    return Error(Errc::kAnsweredError, producer.to_string(widths) +
                                           " ended its stream (off, or failed): subscribe again "
                                           "when it is on");
  }
  if (header.type != tims::type::kData) {
    return Error(Errc::kInvalidArgument, "type " + std::to_string(header.type) + " of " +
                                             producer.to_string(widths) +
                                             " is not data: discard it");
  }
  return {};
}

}  // namespace rack
