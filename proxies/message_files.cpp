#include "proxies/message_files.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <system_error>

#include <boost/json/parse.hpp>

#include "base/text.h"
#include "os/environment.h"
#include "os/file.h"
#include "rack/proxies/generic.h"

namespace rack {

namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr std::size_t kFileMax = 1 << 20;
constexpr std::size_t kNameMax = 64;
constexpr std::size_t kFieldsMax = 200;
constexpr std::size_t kStructsMax = 256;
constexpr std::size_t kFixedMax = 64 << 10;  // bytes of a struct without its sequences
constexpr std::size_t kBodyMax = 16 << 20;

// The position in the file, so that its author can correct it: "structs[2].fields[0].type".
struct Wrong {
  std::string text;
};
[[noreturn]] void wrong(const std::string& where, const std::string& what) {
  throw Wrong{where + " " + what};
}

bool is_identifier(std::string_view text) {
  const auto good = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !text.empty() && text.size() <= kNameMax && std::ranges::all_of(text, good) &&
         (text[0] < '0' || text[0] > '9');
}

bool is_unit(std::string_view text) {
  return text.size() <= 16 && std::ranges::all_of(text, [](char c) { return c > ' ' && c <= '~'; });
}

const json::object& object_in(const json::value& value, const std::string& where) {
  const json::object* object = value.if_object();
  if (object == nullptr) wrong(where, "is not an object");
  return *object;
}

const json::array& list_in(const json::object& object, std::string_view key,
                           const std::string& where, std::size_t max) {
  const json::value* value = object.if_contains(key);
  const json::array* list = value == nullptr ? nullptr : value->if_array();
  if (list == nullptr || list->empty() || list->size() > max)
    wrong(where + std::string(key), "is not a list of 1 to " + std::to_string(max));
  return *list;
}

std::string_view identifier_in(const json::object& object, std::string_view key,
                               const std::string& where) {
  const json::value* value = object.if_contains(key);
  const json::string* text = value == nullptr ? nullptr : value->if_string();
  if (text == nullptr || !is_identifier(*text))
    wrong(where + std::string(key),
          "is not a name of letters, digits and _, at most " + std::to_string(kNameMax));
  return *text;
}

std::optional<i64> number_in(const json::object& object, std::string_view key,
                             const std::string& where, i64 min, i64 max) {
  const json::value* value = object.if_contains(key);
  if (value == nullptr) return std::nullopt;
  const auto range =
      "is not a whole number from " + std::to_string(min) + " to " + std::to_string(max);
  const i64* number = value->if_int64();
  if (number == nullptr || *number < min || *number > max) wrong(where + std::string(key), range);
  return *number;
}

std::vector<std::byte> bytes_in(const json::object& object, std::string_view key,
                                const std::string& where) {
  const json::value* value = object.if_contains(key);
  const json::string* digits = value == nullptr ? nullptr : value->if_string();
  auto bytes = digits == nullptr ? std::nullopt : tims::base::parse_hex(*digits);
  if (!bytes) wrong(where + std::string(key), "is not a text of pairs of hex digits");
  return *std::move(bytes);
}

constexpr FieldType kNumbers[] = {
    FieldType::kI8,   FieldType::kU8,   FieldType::kI16,     FieldType::kU16,  FieldType::kI32,
    FieldType::kU32,  FieldType::kI64,  FieldType::kU64,     FieldType::kF32,  FieldType::kF64,
    FieldType::kByte, FieldType::kTime, FieldType::kAddress, FieldType::kCount};

std::string at(std::string_view list, std::size_t index) {
  return std::string(list) + "[" + std::to_string(index) + "].";
}

}  // namespace

class MessageFileReader {
 public:
  explicit MessageFileReader(MessageFile& file) : file_(file) {}

  void read(const json::value& root) {
    const json::object& object = object_in(root, "the file");
    if (number_in(object, "rack_messages", "", 1, 1) != 1)
      wrong("rack_messages", "is missing: this is not a message file");
    read_class(object);
    if (object.if_contains("structs") != nullptr) {
      const json::array& structs = list_in(object, "structs", "", kStructsMax);
      for (std::size_t i = 0; i < structs.size(); ++i) read_struct(structs[i], at("structs", i));
    }
    const json::array& messages = list_in(object, "messages", "", 256);
    for (std::size_t i = 0; i < messages.size(); ++i) read_message(messages[i], at("messages", i));
    file_.class_.messages = file_.messages_;
  }

 private:
  std::string_view keep(std::string_view text) { return file_.texts_.emplace_back(text); }

  void read_class(const json::object& object) {
    file_.class_.name = keep(identifier_in(object, "class", ""));
    file_.class_.class_id = class_id_in(object);
    for (const ClassInfo& other : added_classes())  // the same class again
      if (other.class_id == file_.class_.class_id && other.name == file_.class_.name) return;
    if (const auto known = tims::class_name(file_.class_.class_id); !known.empty())
      wrong("class_id", class_number(file_.class_.class_id) + " is the number of " +
                            std::string(known) + ": use a number from 128 on");
    if (tims::class_id_of(file_.class_.name))
      wrong("class", std::string(file_.class_.name) + " is a class of RACK itself");
  }

  // A number, or a text with the number in hexadecimal: "0x80".
  static u32 class_id_in(const json::object& object) {
    constexpr i64 kMax = 0xFFFFFF;
    const json::value* value = object.if_contains("class_id");
    const json::string* text = value == nullptr ? nullptr : value->if_string();
    if (text == nullptr) {
      const auto id = number_in(object, "class_id", "", 0, kMax);
      if (!id) wrong("class_id", "is missing");
      return static_cast<u32>(*id);
    }
    const auto id = text->starts_with("0x")
                        ? tims::base::parse_number<u32>(std::string_view(*text).substr(2), 16)
                        : std::nullopt;
    if (!id || *id > kMax) wrong("class_id", "is not a number such as 128 or \"0x80\"");
    return *id;
  }

  void read_message(const json::value& value, const std::string& where) {
    const json::object& object = object_in(value, where);
    MessageInfo message{.class_id = file_.class_.class_id};
    message.name = keep(identifier_in(object, "name", where));
    const auto type = number_in(object, "type", where, -128, 127);
    if (!type) wrong(where + "type", "is missing");
    message.type = static_cast<i8>(*type);
    if (find_message(kEveryClass, message.type) != nullptr ||
        (message.type > 0 && message.type < kFirstCommand))
      wrong(where + "type",
            std::to_string(*type) + " is a message of every class: commands begin at " +
                std::to_string(kFirstCommand) + ", answers at " + std::to_string(kFirstReply));
    for (const MessageInfo& other : file_.messages_)
      if (other.type == message.type || other.name == message.name)
        wrong(where + "type", "or name is taken by " + std::string(other.name));
    if (object.if_contains("body") != nullptr) {
      const std::string_view body = identifier_in(object, "body", where);
      message.body = find_struct(body);
      if (message.body == nullptr)
        wrong(where + "body", std::string(body) + " is not a struct in this file");
    }
    file_.messages_.push_back(message);
  }

  [[nodiscard]] const Schema* find_struct(std::string_view name) const {
    const auto found = std::ranges::find(file_.structs_, name, &Schema::name);
    return found == file_.structs_.end() ? nullptr : &*found;
  }

  void read_struct(const json::value& value, const std::string& where) {
    const json::object& object = object_in(value, where);
    Schema schema{.name = keep(identifier_in(object, "name", where))};
    if (find_struct(schema.name) != nullptr)
      wrong(where + "name", std::string(schema.name) + " is defined twice");
    auto& fields = file_.fields_.emplace_back();
    const json::array& list = list_in(object, "fields", where, kFieldsMax);
    for (std::size_t i = 0; i < list.size(); ++i)
      add_field(schema, fields, read_field(list[i], where + at("fields", i)),
                where + at("fields", i));
    schema.fields = fields;
    check_count(fields, where);
    schema.size_max += schema.size_min;
    read_sizes(schema, object, where);
    file_.structs_.push_back(schema);
    // Last, because it is decoded with the finished schema.
    auto& made = file_.made_.emplace_back(bytes_in(object, "made", where));
    if (const auto good = read_value(schema, made, std::endian::little); !good)
      wrong(where + "made", "does not fit: " + good.error().detail());
    file_.structs_.back().made_bytes = made;
  }

  static void read_sizes(Schema& schema, const json::object& object, const std::string& where) {
    constexpr auto kMax = static_cast<i64>(kBodyMax);
    schema.whole_size =
        static_cast<std::size_t>(number_in(object, "whole_size", where, 0, kMax).value_or(0));
    schema.surplus =
        static_cast<std::size_t>(number_in(object, "surplus", where, 0, kMax).value_or(0));
    schema.pads = number_in(object, "pads", where, 0, 1).value_or(0) == 1;
    schema.size_max = std::max(schema.size_max + schema.surplus, schema.whole_size);
  }

  SchemaField read_field(const json::value& value, const std::string& where) {
    const json::object& object = object_in(value, where);
    SchemaField field{.name = keep(identifier_in(object, "name", where))};
    read_type(field, object, where);
    if (const auto times = number_in(object, "times", where, 1, kFixedMax)) {
      field.repeat = Repeat::kArray;
      field.times = static_cast<std::size_t>(*times);
    }
    if (const auto most = number_in(object, "at_most", where, 1, kBodyMax)) {
      if (field.repeat != Repeat::kNot) wrong(where + "at_most", "and times exclude each other");
      field.repeat = Repeat::kSequence;
      field.times = static_cast<std::size_t>(*most);
    }
    if (field.type == FieldType::kChar && field.repeat != Repeat::kSequence)
      wrong(where + "type", "char requires at_most: a text of fixed size has the type text");
    if (field.type == FieldType::kCount && field.repeat != Repeat::kNot)
      wrong(where + "type", "count cannot repeat");
    read_unit(field, object, where);
    return field;
  }

  void read_type(SchemaField& field, const json::object& object, const std::string& where) const {
    const std::string_view type = identifier_in(object, "type", where);
    if (type == "text") {
      field.type = FieldType::kText;
      const auto bytes = number_in(object, "bytes", where, 2, kFixedMax);
      if (!bytes) wrong(where + "bytes", "is missing: give the size of the text");
      field.size = static_cast<std::size_t>(*bytes);
    } else if (type == "char") {
      field.type = FieldType::kChar;
      field.size = 1;
    } else if (const auto* const number =
                   std::ranges::find(kNumbers, type, [](FieldType t) { return name(t); });
               number != std::end(kNumbers)) {
      field.type = *number;
      field.size = size_of(field.type);
    } else {
      field.type = FieldType::kStruct;
      field.inner = find_struct(type);
      if (field.inner == nullptr)
        wrong(where + "type",
              std::string(type) + " is neither a type nor a struct defined before this one");
      field.size = field.inner->size_min;
    }
  }

  void read_unit(SchemaField& field, const json::object& object, const std::string& where) {
    for (const auto& [key, to] : {std::pair{"unit", &field.unit}, {"si_unit", &field.si_unit}}) {
      const json::value* value = object.if_contains(key);
      if (value == nullptr) continue;
      const json::string* text = value->if_string();
      if (text == nullptr || !is_unit(*text)) wrong(where + key, "is not a unit such as \"mm/s\"");
      *to = keep(*text);
    }
    if (field.unit.empty()) return;
    const bool measures = size_of(field.type) > 0 && field.type != FieldType::kAddress &&
                          field.type != FieldType::kCount;
    if (!measures) wrong(where + "unit", "is for numbers");
    if (field.si_unit.empty()) field.si_unit = field.unit;
    if (const json::value* si = object.if_contains("si")) {
      if (!si->is_number()) wrong(where + "si", "is not a number");
      field.si = si->to_number<f64>();
      if (!(field.si > 1e-30 && field.si < 1e30)) wrong(where + "si", "is out of range");
    }
  }

  // Inner structs and arrays must have a fixed size; sequences must be the last fields.
  static void add_field(Schema& schema, std::vector<SchemaField>& fields, const SchemaField& field,
                        const std::string& where) {
    if (std::ranges::find(fields, field.name, &SchemaField::name) != fields.end())
      wrong(where + "name", std::string(field.name) + " is defined twice");
    if (field.inner != nullptr &&
        std::ranges::any_of(field.inner->fields, [](const SchemaField& inner) {
          return inner.repeat == Repeat::kSequence || inner.type == FieldType::kCount;
        }))
      wrong(where + "type",
            std::string(field.inner->name) + " has a sequence: only a whole message may");
    const bool behind = !fields.empty() && fields.back().repeat == Repeat::kSequence;
    if (behind && field.repeat != Repeat::kSequence)
      wrong(where + "name",
            std::string(field.name) + " follows a sequence: sequences must be last");
    std::size_t& size = field.repeat == Repeat::kSequence ? schema.size_max : schema.size_min;
    const std::size_t max = field.repeat == Repeat::kSequence ? kBodyMax : kFixedMax;
    if (field.times > max / field.size || size + field.times * field.size > max)
      wrong(where + "name", "makes the struct larger than " + std::to_string(max) + " bytes");
    size += field.times * field.size;
    fields.push_back(field);
  }

  static void check_count(const std::vector<SchemaField>& fields, const std::string& where) {
    const auto counts = std::ranges::count(fields, FieldType::kCount, &SchemaField::type);
    const auto sequences = std::ranges::count(fields, Repeat::kSequence, &SchemaField::repeat);
    if (counts > 1 || (counts == 1) != (sequences > 0))
      wrong(where + "fields", "have a count without a sequence or a sequence without a count");
  }

  MessageFile& file_;
};

Result<std::unique_ptr<MessageFile>> MessageFile::parse(std::string_view text) {
  boost::system::error_code error;
  const json::value root = json::parse(text, error);
  if (error) return tims::Error(tims::Errc::kMalformed, "not JSON: " + error.message());
  std::unique_ptr<MessageFile> file(new MessageFile);
  try {
    MessageFileReader(*file).read(root);
  } catch (const Wrong& what) {
    return tims::Error(tims::Errc::kMalformed, what.text);
  }
  return file;
}

namespace {

// Kept until the program ends, because the catalogue refers to them.
std::deque<std::unique_ptr<MessageFile>>& loaded() {
  static std::deque<std::unique_ptr<MessageFile>> files;
  return files;
}

// Returns the problem; empty: none.
std::string load(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return path + ": is not a file";
  const auto content = tims::os::read_file(path, kFileMax);
  if (!content) return content.error().detail();
  auto file = MessageFile::parse(*content);
  if (!file) return path + ": " + file.error().detail();
  // If another file has described this class before, that file has priority.
  if (const auto added = add_class((*file)->class_info()); !added)
    return path + ": " + added.error().detail();
  loaded().push_back(*std::move(file));
  return {};
}

std::vector<fs::path> files_in(const fs::path& place) {
  std::error_code error;
  if (!fs::is_directory(place, error)) return {place};
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(place, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->path().extension() == ".json") files.push_back(entry->path());
  std::ranges::sort(files);
  return files;
}

std::vector<fs::path> places() {
  std::vector<fs::path> places;
  const std::string given = tims::os::environment("RACK_MESSAGES");
  for (std::string_view left = given; !left.empty();) {
    const std::size_t end = std::min(left.find(':'), left.size());
    if (end > 0) places.emplace_back(left.substr(0, end));
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  for (const fs::path& prefix :
       {program.parent_path().parent_path(), fs::path("/usr/local"), fs::path("/usr")}) {
    const fs::path folder = prefix / "share/rack/messages";
    if (fs::is_directory(folder, error) && std::ranges::find(places, folder) == places.end())
      places.push_back(folder);
  }
  return places;
}

}  // namespace

std::string message_places() {
  std::string text;
  for (const fs::path& place : places())
    text.append(text.empty() ? "its messages are described by no file in " : ", ")
        .append(place.string());
  if (text.empty()) text = "no folder with descriptions of messages was found";
  const bool given = !tims::os::environment("RACK_MESSAGES").empty();
  return text + (given ? " (RACK_MESSAGES)"
                       : "; RACK_MESSAGES is not set: set it to the file, or the folder "
                         "share/rack/messages of its build");
}

std::vector<std::string> load_message_files() {
  std::vector<std::string> problems;
  for (const fs::path& place : places()) {
    for (const fs::path& file : files_in(place)) {
      if (std::string problem = load(file); !problem.empty())
        problems.push_back(std::move(problem));
    }
  }
  return problems;
}

}  // namespace rack
