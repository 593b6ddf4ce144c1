// Which message is the answer a call waits for: pure, so that every case can be tested.
#pragma once

#include <algorithm>
#include <span>

#include "proxies/codec/quantity.h"
#include "tims/message.h"

namespace rack {

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

}  // namespace rack
