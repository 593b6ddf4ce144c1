// timsctl msg types and show: the catalogue of messages; needs no router.
#include <fmt/format.h>

#include "router/config/nearest.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/message_fields.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

constexpr Column kTypes[] = {
    {"NAME", "name"},
    {"CLASS", "class"},
    {"TYPE", "type", As::kCount},
    {"BODY", "body"},
    {"MAX", "body_max_bytes", As::kBytes},
};

constexpr Column kFields[] = {
    {"FIELD", "name"},
    {"UNIT", "unit"},
    {"SI", "si_unit"},
    {"TYPE", "type"},
};

json::object message_item(const rack::MessageInfo& message) {
  const std::string_view name = tims::class_name(message.class_id);
  json::object item{{"class", message.class_id == rack::kEveryClass ? "every" : name},
                    {"type", message.type},
                    {"name", lower(message.name)},
                    {"body", nullptr},
                    {"body_max_bytes", 0}};
  if (message.body == nullptr) return item;
  item["body"] = message.body->name;
  item["body_max_bytes"] = message.body->body_max;
  return item;
}

json::array fields_of(const rack::MessageInfo& message) {
  json::array items;
  if (message.body == nullptr) return items;
  for (const rack::Column& column : message.body->columns())
    items.push_back({{"name", column.name},
                     {"unit", column.unit},
                     {"si_unit", column.si_unit},
                     {"type", column.type}});
  return items;
}

}  // namespace

Exit msg_types(Context& context) {
  const auto& arguments = context.options.arguments;
  std::optional<std::uint32_t> class_id;
  if (!arguments.empty() && lower(arguments[0]) == "every")
    class_id = rack::kEveryClass;
  else if (!arguments.empty())
    class_id = need_class(arguments[0]);
  json::array items;
  for (const auto table : rack::message_tables())
    for (const rack::MessageInfo& message : table)
      if (!class_id || message.class_id == *class_id) items.push_back(message_item(message));
  if (context.out.json())
    context.out.write(
        json::object{{"schema", "tims/message_types/1"}, {"items", std::move(items)}});
  else
    context.out.write(render_items({items.data(), items.size()}, kTypes, context.out.look()));
  return Exit::kDone;
}

Exit msg_show(Context& context) {
  const auto& arguments = context.options.arguments;
  const std::uint32_t class_id = need_class(arguments[0]);
  const rack::MessageInfo& message = need_message(class_id, arguments[1]);
  json::object answer = message_item(message);
  const json::array fields = fields_of(message);
  if (context.out.json()) {
    answer["schema"] = "tims/message_type/1";
    answer["fields"] = fields;
    context.out.write(answer);
    return Exit::kDone;
  }
  const Look& look = context.out.look();
  if (look.format == Format::kTable || look.format == Format::kWide) {
    const bool framework = message.class_id == rack::kEveryClass;
    context.out.write(fmt::format(
        "{}{} (type {}){}\n", lower(message.name), framework ? ", of every class" : "",
        message.type,
        message.body == nullptr ? ": no body" : fmt::format(": {}", message.body->name)));
  }
  if (!fields.empty())
    context.out.write(render_items({fields.data(), fields.size()}, kFields, look));
  return Exit::kDone;
}

}  // namespace timsctl
