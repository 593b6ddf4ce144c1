// Bodies with arbitrary content. The same seed gives the same vectors with every compiler, so no
// distributions of the standard library are used.
#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <random>

#include "base/text.h"
#include "proxies/catalogue_text.h"
#include "rack/codec/message_text.h"

namespace rack {

namespace {

constexpr std::size_t kElementsMax = 4;  // of a sequence, so that the vectors stay small
constexpr std::size_t kTailMax = 64;
constexpr int kBodies = 4;   // of each struct and byte order
constexpr int kDamaged = 6;  // copies of each body

class Arbitrary {
 public:
  explicit Arbitrary(std::uint64_t seed) : random_(seed) {}

  std::size_t below(std::size_t end) { return random_() % end; }

  // Numbers of a struct with a tail are small, because the length of the tail depends on them.
  MessageValue of(const Schema& schema, bool small = false) {
    small = small || schema.tail_size != nullptr;
    std::vector<MessageValue> values;
    for (const SchemaField& field : schema.fields)
      values.push_back(field.repeat == Repeat::kNot ? one(field, small) : many(field, small));
    return {std::move(values)};
  }

  MessageValue elements(const SchemaField& field, std::size_t count) {
    if (field.is_blob()) {
      std::string bytes;
      while (bytes.size() < count) bytes += static_cast<char>(below(256));
      return {std::move(bytes)};
    }
    std::vector<MessageValue> list;
    while (list.size() < count) list.push_back(one(field, false));
    return {std::move(list)};
  }

 private:
  MessageValue many(const SchemaField& field, bool small) {
    if (field.repeat == Repeat::kTail) return elements(field, 0);  // set when its length is known
    if (field.repeat == Repeat::kSequence)
      return elements(field, below(std::min(field.times, kElementsMax) + 1));
    std::vector<MessageValue> list;
    while (list.size() < field.times) list.push_back(one(field, small));
    return {std::move(list)};
  }

  MessageValue one(const SchemaField& field, bool small) {
    if (field.type == FieldType::kStruct) return of(*field.inner, small);
    if (field.type == FieldType::kText) {
      std::string text;
      for (std::size_t size = below(field.size); text.size() < size;)
        text += static_cast<char>(1 + below(255));
      return {std::move(text)};
    }
    return with_number(field.type, [&](auto number) {
      return MessageValue::of_number(this->number<decltype(number)>(small));
    });
  }

  template <typename T>
  T number(bool small) {
    if constexpr (std::is_floating_point_v<T>) {
      using Limits = std::numeric_limits<T>;
      constexpr std::array kSpecial = {T{0},
                                       -T{0},
                                       T(0.1),
                                       T(-1e-7),
                                       T(1.5e9),
                                       Limits::max(),
                                       Limits::min(),
                                       Limits::quiet_NaN(),
                                       Limits::denorm_min(),
                                       Limits::infinity(),
                                       -Limits::infinity()};
      if (below(2) == 0) return kSpecial.at(below(kSpecial.size()));
      return static_cast<T>(static_cast<std::int32_t>(random_() >> 32)) / T(1 + below(1000));
    } else {
      if (small) return static_cast<T>(below(6));
      using Limits = std::numeric_limits<T>;
      constexpr std::array kSpecial = {T{0},
                                       T{1},
                                       Limits::max(),
                                       Limits::min(),
                                       static_cast<T>(-1),
                                       static_cast<T>(kNobody.raw())};
      if (below(3) == 0) return kSpecial.at(below(kSpecial.size()));
      return static_cast<T>(random_());
    }
  }

  std::mt19937_64 random_;
};

class Vectors {
 public:
  explicit Vectors(std::uint64_t seed) : arbitrary_(seed) {}

  void add(const Schema& schema, std::endian order) {
    order_ = order;
    const auto body = body_of(schema);
    append_with_truncations(schema, body);
    for (int i = 0; i < kDamaged && !body.empty(); ++i) {
      auto damaged = body;
      damaged.at(arbitrary_.below(body.size())) = static_cast<std::byte>(arbitrary_.below(256));
      append_with_truncations(schema, damaged);
    }
    auto longer = body;
    longer.push_back(std::byte{1});
    append(schema, longer);
  }

  std::string take() { return std::move(out_); }

 private:
  void append_with_truncations(const Schema& schema, std::span<const std::byte> body) {
    append(schema, body);
    for (std::size_t size = 0; size < body.size(); ++size)
      if (read_value(schema, body.first(size), order_)) append(schema, body.first(size));
  }

  void append(const Schema& schema, std::span<const std::byte> body) {
    out_.append(schema.name).append(order_ == std::endian::little ? " little " : " big ");
    out_.append(body.empty() ? "-" : tims::base::to_hex(body)).append(" ");
    const auto json = body_json(schema, body, order_);
    out_.append(json ? *json : "!" + json.error().detail()).append("\n");
  }

  std::vector<std::byte> body_of(const Schema& schema) {
    for (;;) {
      MessageValue value = arbitrary_.of(schema);
      if (schema.tail_size == nullptr || set_tails(schema, value))
        return *write_value(schema, value, order_);
    }
  }

  // False: the numbers of the struct do not give a small length.
  bool set_tails(const Schema& schema, MessageValue& value) {
    Schema without = schema;  // the fields before the tails, which are the last ones
    const auto first = std::ranges::find(schema.fields, Repeat::kTail, &SchemaField::repeat);
    const auto fixed = static_cast<std::size_t>(first - schema.fields.begin());
    without.fields = schema.fields.first(fixed);
    const auto head = *write_value(without, value, order_);
    for (std::size_t i = fixed; i < schema.fields.size(); ++i) {
      const std::int64_t size = schema.tail_size(head, order_, i - fixed);
      if (size < 0 || size > static_cast<std::int64_t>(kTailMax)) return false;
      value.list().at(i) = arbitrary_.elements(schema.fields[i], static_cast<std::size_t>(size));
    }
    return true;
  }

  Arbitrary arbitrary_;
  std::endian order_ = std::endian::little;
  std::string out_;
};

}  // namespace

std::string catalogue_vectors(std::uint64_t seed) {
  Vectors vectors(seed);
  for (const Schema* schema : own_bodies())
    for (int i = 0; i < kBodies; ++i)
      for (const auto order : {std::endian::little, std::endian::big}) vectors.add(*schema, order);
  return vectors.take();
}

}  // namespace rack
