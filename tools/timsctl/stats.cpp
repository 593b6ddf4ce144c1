// timsctl stats: what became of messages.
#include <algorithm>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "base/wall_time.h"
#include "tools/cli/context.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

constexpr Column kAll[] = {
    {"PORT", "port"},
    {"CLASS", "class"},
    {"OUTCOME", "outcome"},
    {"MESSAGES", "messages", As::kCount},
    {"BYTES", "bytes", As::kBytes},
    {"MEANING", "meaning"},
};
constexpr Column kByReason[] = {
    {"OUTCOME", "outcome"},
    {"MESSAGES", "messages", As::kCount},
    {"BYTES", "bytes", As::kBytes},
    {"MEANING", "meaning"},
};
constexpr Column kByPort[] = {
    {"PORT", "port"},
    {"MESSAGES", "messages", As::kCount},
    {"BYTES", "bytes", As::kBytes},
    {"DROPPED", "dropped_messages", As::kCount, false, true},
};
constexpr Column kByClass[] = {
    {"CLASS", "class"},
    {"PRIORITIES", "priorities"},
    {"MESSAGES", "messages", As::kCount},
    {"BYTES", "bytes", As::kBytes},
    {"DROPPED", "dropped_messages", As::kCount, false, true},
};

void add(json::object& item, std::string_view key, double more) {
  item[key] = static_cast<std::uint64_t>(number_or_zero(item, key) + more);
}

// "15-24"; "texts" for what no priority leads to.
std::string priorities_of(const json::value& message_class, const json::array& classes) {
  if (classes.empty()) return {};  // of an older router
  const auto number = message_class.to_number<std::size_t>();
  const auto first_of = [&](std::size_t i) {
    if (i == 0) return 0;
    return i <= classes.size() ? classes[i - 1].to_number<int>() : 256;
  };
  const int first = first_of(number);
  const int last = first_of(number + 1) - 1;
  if (last < first) return "texts";
  return first == last ? std::to_string(first) : fmt::format("{}-{}", first, last);
}

// One item for each value of `key`, the numbers added up.
json::array grouped(std::span<const json::value> items, std::string_view key,
                    const json::array& classes) {
  json::array groups;
  for (const json::value& value : items) {
    const json::object& item = value.as_object();
    auto group = std::ranges::find_if(groups, [&](const json::value& g) {
      return text_at(g.as_object(), key) == text_at(item, key);
    });
    if (group == groups.end()) {
      json::object fresh{{key, item.at(key)}};
      if (key == "outcome") fresh["meaning"] = item.at("meaning");
      if (key == "class") fresh["priorities"] = priorities_of(item.at("class"), classes);
      groups.push_back(std::move(fresh));
      group = groups.end() - 1;
    }
    const bool dropped = text_at(item, "dropped") == "true";
    json::object& sum = group->as_object();
    add(sum, "messages", number_or_zero(item, "messages"));
    add(sum, "bytes", number_or_zero(item, "bytes"));
    add(sum, "dropped_messages", dropped ? number_or_zero(item, "messages") : 0);
  }
  return groups;
}

// What went past the router, between programs of its host, is counted by the mailboxes alone.
std::string mailboxes_line(const json::object& answer) {
  const auto count = [&](std::string_view name) {
    return base::human_count(number_or_zero(answer, fmt::format("mailboxes.{}", name)));
  };
  return fmt::format(
      "\nMailboxes of this host: {} received, {} replaced, {} refused, {} too big, "
      "{} left half-written\n",
      count("received"), count("replaced"), count("refused"), count("too_big"), count("reclaimed"));
}

}  // namespace

Exit stats(Context& context) {
  const std::string& by = context.options.by;
  std::span<const Column> columns = kAll;
  if (by == "reason") columns = kByReason;
  if (by == "port") columns = kByPort;
  if (by == "class") columns = kByClass;
  const auto ask = [&](AdminClient& admin) {
    json::object answer = admin.ask({{"ask", "stats"}});
    if (!by.empty())
      answer["items"] =
          grouped(items_of(std::as_const(answer)), by == "reason" ? "outcome" : by,
                  answer.contains("classes") ? answer.at("classes").as_array() : json::array());
    if (!context.options.sort.empty()) sort_items(items_of(answer), columns, context.options.sort);
    return answer;
  };
  const auto draw = [&](const json::object& answer, const Look& look) {
    const std::string table = render_items(items_of(answer), columns, look);
    const bool for_people = look.format == Format::kTable || look.format == Format::kWide;
    return for_people ? table + mailboxes_line(answer) : table;
  };
  return show(context, ask, draw);
}

}  // namespace timsctl
