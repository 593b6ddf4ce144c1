#include "rack/codec/schema.h"

#include <algorithm>
#include <array>
#include <utility>

namespace rack {

namespace {

using Bytes = Schema::Bytes;

std::size_t elements(const SchemaField& field, const MessageValue& value) {
  return field.is_blob() ? value.text().size() : value.list().size();
}

// --- bytes to values

MessageValue read_struct(const Schema& schema, const std::byte*& from, std::endian order);

MessageValue read_one(const SchemaField& field, const std::byte*& from, std::endian order) {
  if (field.type == FieldType::kStruct) return read_struct(*field.inner, from, order);
  const std::byte* const at = std::exchange(from, from + field.size);
  if (field.type == FieldType::kText) {
    const std::string_view text(reinterpret_cast<const char*>(at), field.size - 1);
    return {std::string(text.substr(0, text.find('\0')))};
  }
  return with_number(field.type, [&](auto number) {
    bytes::read(at, order, number);
    return MessageValue::of_number(number);
  });
}

MessageValue read_many(const SchemaField& field, std::size_t count, const std::byte*& from,
                       std::endian order) {
  if (field.is_blob()) {
    const auto* const text = reinterpret_cast<const char*>(std::exchange(from, from + count));
    return {std::string(text, count)};
  }
  std::vector<MessageValue> list;
  list.reserve(count);
  for (std::size_t i = 0; i < count; ++i) list.push_back(read_one(field, from, order));
  return {std::move(list)};
}

MessageValue read_struct(const Schema& schema, const std::byte*& from, std::endian order) {
  std::vector<MessageValue> values;
  values.reserve(schema.fields.size());
  for (const SchemaField& field : schema.fields)
    values.push_back(field.repeat == Repeat::kArray ? read_many(field, field.times, from, order)
                                                    : read_one(field, from, order));
  return {std::move(values)};
}

// Reads a whole body. It never reads beyond the end, whatever lengths the body states.
class Reader {
 public:
  Reader(const Schema& schema, Bytes body, std::endian order)
      : schema_(schema), body_(body), order_(order), from_(body.data()) {}

  Result<MessageValue> run() {
    if (body_.size() < schema_.size_min)
      return codec::too_short(schema_.name, schema_.size_min, body_.size());
    std::vector<MessageValue> values;
    values.reserve(schema_.fields.size());
    for (const SchemaField& field : schema_.fields) {
      auto value = read(field);
      if (!value) return value.error();
      values.push_back(*std::move(value));
    }
    const std::size_t there = body_.size();
    const std::size_t used = there - left();
    if (there != used && there != schema_.whole_size &&
        !(schema_.surplus > 0 && left() == schema_.surplus))
      return codec::surplus(schema_.name, used, there);
    return MessageValue{std::move(values)};
  }

 private:
  [[nodiscard]] std::size_t left() const {
    return body_.size() - static_cast<std::size_t>(from_ - body_.data());
  }

  Result<MessageValue> read(const SchemaField& field) {
    switch (field.repeat) {
      case Repeat::kNot:
        break;
      case Repeat::kArray:
        return read_many(field, field.times, from_, order_);
      case Repeat::kSequence:  // an error names its count, which is the field on the wire
        return read_elements(field, count_, count_name_.empty() ? field.name : count_name_);
      case Repeat::kTail:
        return read_elements(field, schema_.tail_size(body_, order_, tails_++), field.name);
    }
    MessageValue value = read_one(field, from_, order_);
    if (field.type == FieldType::kCount) {
      count_ = value.number<std::int64_t>();
      count_name_ = field.name;
    }
    return value;
  }

  Result<MessageValue> read_elements(const SchemaField& field, std::int64_t count,
                                     std::string_view name) {
    const codec::FieldName field_name{schema_.name, name};
    if (count < 0 || count > static_cast<std::int64_t>(field.times))
      return codec::bad_count(field_name, count, field.times);
    const auto wanted = static_cast<std::size_t>(count);
    if (wanted * field.size > left())
      return codec::elements_missing(field_name, wanted * field.size, left());
    return read_many(field, wanted, from_, order_);
  }

  const Schema& schema_;
  Bytes body_;
  std::endian order_;
  const std::byte* from_;
  std::int64_t count_ = 0;
  std::string_view count_name_;
  std::size_t tails_ = 0;
};

// --- values to bytes

class Writer {
 public:
  explicit Writer(std::endian order) : order_(order) {}

  Result<std::vector<std::byte>> run(const Schema& schema,
                                     const std::vector<MessageValue>& values) {
    std::size_t tails = 0;
    for (std::size_t i = 0; i < schema.fields.size(); ++i) {
      const SchemaField& field = schema.fields[i];
      const codec::FieldName field_name{schema.name, field.name};
      if (field.is_variable() && elements(field, values[i]) > field.times)
        return codec::too_many(field_name, elements(field, values[i]), field.times);
      if (field.repeat == Repeat::kTail) {
        const std::int64_t stated = schema.tail_size(out_, order_, tails++);
        if (std::cmp_not_equal(elements(field, values[i]), stated))
          return codec::wrong_tail(field_name, elements(field, values[i]), stated);
      }
      if (field.type == FieldType::kCount) {
        put(static_cast<i32>(counted(schema, values, i)));
      } else {
        put(field, values[i]);
      }
    }
    if (schema.pads) out_.resize(std::max(out_.size(), schema.whole_size));
    return std::move(out_);
  }

 private:
  template <typename T>
  void put(T number) {
    std::array<std::byte, sizeof number> sent;
    bytes::write(sent.data(), order_, number);
    out_.insert(out_.end(), sent.begin(), sent.end());
  }

  void put_text(const std::string& text, std::size_t size) {
    const auto* const from = reinterpret_cast<const std::byte*>(text.data());
    out_.insert(out_.end(), from, from + std::min(text.size(), size));
    out_.resize(out_.size() + size - std::min(text.size(), size));
  }

  void put(const SchemaField& field, const MessageValue& value) {
    if (field.repeat == Repeat::kNot) return put_one(field, value);
    if (field.is_blob()) return put_text(value.text(), value.text().size());
    for (const MessageValue& element : value.list()) put_one(field, element);
  }

  void put_one(const SchemaField& field, const MessageValue& value) {
    if (field.type == FieldType::kText) return put_text(value.text(), field.size);
    if (field.type != FieldType::kStruct)
      return with_number(field.type, [&]<typename T>(T) { put(value.template number<T>()); });
    for (std::size_t i = 0; i < field.inner->fields.size(); ++i)
      put(field.inner->fields[i], value.list()[i]);
  }

  std::endian order_;
  std::vector<std::byte> out_;
};

}  // namespace

// --- public functions

std::size_t counted(const Schema& schema, const std::vector<MessageValue>& values,
                    std::size_t field) {
  for (std::size_t i = field + 1; i < schema.fields.size(); ++i) {
    if (schema.fields[i].repeat == Repeat::kSequence) return elements(schema.fields[i], values[i]);
  }
  return 0;
}

Result<MessageValue> read_value(const Schema& schema, Bytes body, std::endian order) {
  return Reader(schema, body, order).run();
}

Result<std::vector<std::byte>> write_value(const Schema& schema, const MessageValue& value,
                                           std::endian order) {
  return Writer(order).run(schema, value.list());
}

Result<std::vector<std::byte>> recode(const Schema& schema, Bytes body, std::endian from,
                                      std::endian to) {
  const auto value = read_value(schema, body, from);
  if (!value) return value.error();
  return write_value(schema, *value, to);
}

MessageValue made_value(const Schema& schema) {
  std::vector<std::byte> body(schema.made_bytes.begin(), schema.made_bytes.end());
  if (schema.made != nullptr) body = schema.made();
  if (body.empty()) body.resize(schema.size_min);
  return *read_value(schema, body, std::endian::little);
}

MessageValue made_value(const SchemaField& field) {
  if (field.type == FieldType::kStruct) return made_value(*field.inner);
  const std::vector<std::byte> zeros(field.size);
  const std::byte* from = zeros.data();
  return read_one(field, from, std::endian::native);
}

std::string_view name(FieldType type) {
  constexpr std::array<std::string_view, 17> kNames = {
      "i8",  "u8",   "i16",  "u16",  "i32",     "u32",  "i64",   "u64",   "f32",
      "f64", "byte", "text", "time", "address", "text", "count", "struct"};
  return kNames.at(static_cast<std::size_t>(type));
}

std::size_t size_of(FieldType type) {
  if (type == FieldType::kText || type == FieldType::kStruct) return 0;
  return with_number(type, [](auto number) { return sizeof number; });
}

}  // namespace rack
