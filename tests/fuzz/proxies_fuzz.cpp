// The body of any message of any class: a decoded body is unchanged after encoding and decoding in
// both byte orders, within the bounds of its struct, and can be printed; the codec of C takes and
// refuses the same bodies, and writes the same bytes.
#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include <rack_messages.h>

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

std::uint8_t flags_of(std::endian order) {
  return order == std::endian::little ? TIMS_BODY_LITTLE_ENDIAN : 0;
}

const rack_body* body_in_c(std::uint8_t class_id, std::int8_t type) {
  const auto find = [type](std::uint8_t of) {
    return std::ranges::find_if(rack_bodies, [&](const rack_body& each) {
      return each.name != nullptr && each.class_id == of && each.type == type;
    });
  };
  const auto* found = find(class_id);
  if (found == std::end(rack_bodies)) found = find(0);
  return found == std::end(rack_bodies) ? nullptr : found;
}

void check_in_c(const rack_body& in_c, const Schema& body, std::span<const std::byte> bytes,
                std::endian order) {
  const rack_layout& layout = *in_c.layout;
  require(layout.name == body.name);
  std::vector<std::uint64_t> value(layout.struct_size / 8 + 1);
  static std::vector<std::byte> memory(std::size_t{24} << 20U);
  rack_problem problem{};
  const int code = rack_decode_struct(&layout, value.data(), flags_of(order), bytes.data(),
                                      bytes.size(), memory.data(), memory.size(), &problem);
  const auto there = recode(body, bytes, order, other(order));
  require((code == 0) == there.ok());
  if (!there) {
    require(there.error().detail() == problem.text);
    return;
  }
  std::vector<std::byte> written(there->size() + 1);
  const std::int64_t size = rack_encode_struct(&layout, value.data(), flags_of(other(order)),
                                               written.data(), there->size(), &problem);
  require(size == std::ssize(*there));
  written.pop_back();
  require(written == *there);
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
  if (message != nullptr && message->body != nullptr) {
    const auto bytes = input.rest();
    check(*message->body, bytes, order);
    const rack_body* in_c = body_in_c(class_id, type);
    require(in_c != nullptr);
    check_in_c(*in_c, *message->body, bytes, order);
  }
  return 0;
}
