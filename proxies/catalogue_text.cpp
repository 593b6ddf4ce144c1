#include "proxies/catalogue_text.h"

#include <algorithm>
#include <set>
#include <string_view>

#include "base/text.h"
#include "proxies/struct_json.h"
#include "proxies/value_names.h"
#include "rack/codec/message_text.h"
#include "tims/address.h"

namespace rack {

namespace {

// From here on, classes are those of other people, which message files have added.
constexpr u32 kOwnClassesEnd = 128;

std::vector<MessageInfo> messages_of(u32 class_id) {
  std::vector<MessageInfo> found;
  for (const auto table : message_tables())
    for (const MessageInfo& message : table)
      if (message.class_id == class_id) found.push_back(message);
  return found;
}

void append_class(std::string& out, u32 class_id) {
  const auto name = tims::class_name(class_id);
  if (name.empty()) return;
  out += out.ends_with('[') ? "\n    {\"id\": " : ",\n    {\"id\": ";
  append_quoted(out.append(std::to_string(class_id)).append(", \"name\": "), name);
  out += ", \"messages\": [";
  append_messages(out, messages_of(class_id), 6);
  out += "]}";
}

void append_names(std::string& out, std::span<const ValueName> names) {
  out += '{';
  for (const ValueName& name : names) {
    append_quoted(out += &name == names.data() ? "" : ", ", name.name);
    out += ": " + std::to_string(name.value);
  }
  out += '}';
}

// --- TypeScript

std::string_view type_of_element(const SchemaField& field) {
  switch (field.type) {
    case FieldType::kStruct:
      return field.inner->name;
    case FieldType::kText:
    case FieldType::kChar:
      return "string";
    case FieldType::kI64:
    case FieldType::kU64:
      return "Integer64";
    default:
      return "number";
  }
}

std::string type_of(const SchemaField& field) {
  const bool is_bytes = field.type == FieldType::kByte || field.type == FieldType::kU8;
  if (field.is_variable() && is_bytes) return "Uint8Array";
  if (field.repeat == Repeat::kNot || field.is_blob()) return std::string(type_of_element(field));
  return std::string(type_of_element(field)) + "[]";
}

void append_interface(std::string& out, const Schema& schema) {
  out.append("\nexport interface ").append(schema.name).append(" {\n");
  for (const SchemaField& field : schema.fields) {
    const bool is_count = field.type == FieldType::kCount;
    out.append("  ").append(field.name).append(is_count ? "?: " : ": ").append(type_of(field));
    out += ';';
    if (!field.unit.empty()) out.append(" // ").append(field.unit);
    out += '\n';
  }
  out += "}\n";
}

void append_interfaces(std::string& out, StructsThere& there, const Schema& schema) {
  if (std::ranges::find(there, &schema) != there.end()) return;
  for (const SchemaField& field : schema.fields)
    if (field.inner != nullptr) append_interfaces(out, there, *field.inner);
  there.push_back(&schema);
  append_interface(out, schema);
}

// A class may have two types with one name.
void append_bodies(std::string& out, u32 class_id) {
  std::set<std::string_view> there;
  for (const MessageInfo& message : messages_of(class_id)) {
    if (!there.insert(message.name).second) continue;
    out += "  '";
    if (class_id != kEveryClass) out.append(tims::class_name(class_id)).append(".");
    out.append(message.name).append("': ");
    out.append(message.body == nullptr ? "undefined" : message.body->name).append(";\n");
  }
}

}  // namespace

std::vector<const Schema*> own_bodies() {
  std::vector<const Schema*> found;
  for (const auto table : message_tables())
    for (const MessageInfo& message : table) {
      const bool ours = message.class_id < kOwnClassesEnd || message.class_id == kEveryClass;
      const bool found_before = std::ranges::find(found, message.body) != found.end();
      if (ours && message.body != nullptr && !found_before) found.push_back(message.body);
    }
  return found;
}

std::string catalogue_json() {
  std::string out = "{\n  \"rack_catalogue\": 1,\n  \"structs\": [";
  StructsThere there;
  for (const Schema* schema : own_bodies()) append_struct(out, there, *schema);
  out += "],\n  \"every_class\": [";
  append_messages(out, messages_of(kEveryClass), 4);
  out += "],\n  \"classes\": [";
  for (u32 id = 0; id < kOwnClassesEnd; ++id) append_class(out, id);
  out += "],\n  \"values\": [";
  for (const FieldValues& field : field_values()) {
    append_quoted(out += out.ends_with('[') ? "\n    {\"field\": " : ",\n    {\"field\": ",
                  field.field);
    append_names(out += ", \"names\": ", field.values);
    append_names(out += ", \"flags\": ", field.flags);
    out += '}';
  }
  return out += "]\n}\n";
}

std::string catalogue_types() {
  std::string out =
      "// Written by tims-schema --types from the C++ structs: do not change it here.\n\n"
      "// A bigint where a number would not be exact.\n"
      "export type Integer64 = number | bigint;\n";
  std::string names = "\nexport interface Structs {\n";
  StructsThere there;
  for (const Schema* schema : own_bodies()) append_interfaces(out, there, *schema);
  for (const Schema* schema : there)
    names.append("  ").append(schema->name).append(": ").append(schema->name).append(";\n");
  out +=
      names + "}\n\n// Bodies by CLASS.MESSAGE; without a class, of the messages of every class.\n";
  out += "export interface Bodies {\n";
  append_bodies(out, kEveryClass);
  for (u32 id = 0; id < kOwnClassesEnd; ++id) append_bodies(out, id);
  return out += "}\n";
}

}  // namespace rack
