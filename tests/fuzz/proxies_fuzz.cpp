// The body of any message of any class: a decoded body is unchanged after encoding and decoding in
// both byte orders, within the bounds of its struct, and can be printed.
#include <string>
#include <vector>

#include "rack/codec/message_text.h"
#include "rack/proxies/catalogue.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using rack::Schema;
using tims::fuzz::require;

std::endian other(std::endian order) {
  return order == std::endian::little ? std::endian::big : std::endian::little;
}

void check(const Schema& body, std::span<const std::byte> bytes, std::endian order) {
  const auto there = recode(body, bytes, order, other(order));
  const auto json = body_json(body, bytes, order, {});
  require(there.ok() == json.ok());
  if (!there) {
    require(!there.error().detail().empty());
    return;
  }
  require(there->size() <= body.size_max);
  const auto back = recode(body, *there, other(order), order);
  require(back.ok() && back->size() == there->size());
  const auto again = recode(body, *back, order, other(order));
  require(again.ok() && *again == *there);
  // The printed text must not depend on the byte order.
  require(*body_json(body, *there, other(order), {}) == *json);
  require(body_text(body, *back, order, {.elements_max = 4}).ok());
}

}  // namespace

// Input: class, type, byte order (bit 0: little endian), body.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tims::fuzz::Input input(data, size);
  const auto class_id = input.number<std::uint8_t>();
  const auto type = input.number<std::int8_t>();
  const std::endian order =
      (input.number<std::uint8_t>() & 1U) != 0 ? std::endian::little : std::endian::big;
  const rack::MessageInfo* message = rack::find_message(class_id, type);
  if (message != nullptr && message->body != nullptr) check(*message->body, input.rest(), order);
  return 0;
}
