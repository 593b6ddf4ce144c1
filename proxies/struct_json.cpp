#include "proxies/struct_json.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "base/text.h"
#include "rack/codec/message_text.h"

namespace rack {

namespace {

std::string_view type_name(const SchemaField& field) {
  if (field.type == FieldType::kStruct) return field.inner->name;
  return field.type == FieldType::kChar ? "char" : name(field.type);
}

std::string hex_of_default(const Schema& schema) {
  return tims::base::to_hex(schema.made == nullptr ? schema.made_bytes : schema.made());
}

void append_field(std::string& out, const SchemaField& field) {
  const auto entry = [&](std::string_view key) -> std::string& {
    return out.append(", \"").append(key).append("\": ");
  };
  out += "{\"name\": ";
  append_quoted(out, field.name);
  append_quoted(entry("type"), type_name(field));
  if (field.type == FieldType::kText) entry("bytes") += std::to_string(field.size);
  if (field.repeat == Repeat::kArray) entry("times") += std::to_string(field.times);
  if (field.repeat == Repeat::kSequence) entry("at_most") += std::to_string(field.times);
  if (field.repeat == Repeat::kTail) entry("tail_at_most") += std::to_string(field.times);
  if (!field.unit.empty()) {
    append_quoted(entry("unit"), field.unit);
    append_quoted(entry("si_unit"), field.si_unit);
    std::array<char, 32> si{};
    entry("si").append(si.data(), std::to_chars(si.data(), si.data() + si.size(), field.si).ptr);
  }
  out += '}';
}

}  // namespace

void append_struct(std::string& out, StructsThere& there, const Schema& schema) {
  if (std::ranges::find(there, &schema) != there.end()) return;
  for (const SchemaField& field : schema.fields)
    if (field.inner != nullptr) append_struct(out, there, *field.inner);
  out += there.empty() ? "\n    {\"name\": " : ",\n    {\"name\": ";
  there.push_back(&schema);
  append_quoted(out, schema.name);
  for (const auto& [key, value] : {std::pair{"whole_size", schema.whole_size},
                                   {"pads", std::size_t{schema.pads}},
                                   {"surplus", schema.surplus}})
    if (value > 0) out.append(", \"").append(key).append("\": ").append(std::to_string(value));
  out.append(", \"made\": \"").append(hex_of_default(schema));
  out += "\", \"fields\": [";
  for (const SchemaField& field : schema.fields) {
    out += &field == schema.fields.data() ? "\n      " : ",\n      ";
    append_field(out, field);
  }
  out += "]}";
}

void append_messages(std::string& out, std::span<const MessageInfo> messages, std::size_t indent) {
  for (const MessageInfo& message : messages) {
    out += &message == messages.data() ? "\n" : ",\n";
    out.append(indent, ' ').append("{\"type\": ").append(std::to_string(message.type));
    append_quoted(out += ", \"name\": ", message.name);
    if (message.body != nullptr) append_quoted(out += ", \"body\": ", message.body->name);
    out += '}';
  }
}

std::string tail_in(const Schema& schema) {
  for (const SchemaField& field : schema.fields) {
    if (field.repeat == Repeat::kTail)
      return std::string(schema.name).append(".").append(field.name);
    if (field.inner == nullptr) continue;
    if (std::string inner = tail_in(*field.inner); !inner.empty()) return inner;
  }
  return {};
}

}  // namespace rack
