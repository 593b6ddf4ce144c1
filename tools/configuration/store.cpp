#include "tools/configuration/store.h"

#include <algorithm>
#include <filesystem>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>

#include "base/text.h"
#include "os/file.h"
#include "os/replace_file.h"

namespace timsctl::configuration {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kStoredMax = 16U << 20;
constexpr mode_t kMode = 0640;

json::array texts(const std::vector<std::string>& all) {
  return json::array(all.begin(), all.end());
}

std::vector<std::string> texts_of(const json::object& object, std::string_view list) {
  std::vector<std::string> all;
  for (const json::value& each : items_of(object, list))
    if (each.is_string()) all.emplace_back(each.get_string());
  return all;
}

Generation number_of(const json::object& object, std::string_view name) {
  return static_cast<Generation>(std::max(number_or_zero(object, name), 0.0));
}

std::optional<Item> item_of(const json::value& value) {
  const json::object* object = value.if_object();
  if (object == nullptr) return std::nullopt;
  const auto outcome = outcome_of(text_at(*object, "outcome"));
  if (!outcome || number_of(*object, "generation") == 0) return std::nullopt;
  return Item{.generation = number_of(*object, "generation"),
              .from = number_of(*object, "from"),
              .change = text_at(*object, "change"),
              .who = text_at(*object, "who"),
              .why = text_at(*object, "why"),
              .time = text_at(*object, "time"),
              .outcome = *outcome,
              .reason = text_at(*object, "reason"),
              .others = texts_of(*object, "others")};
}

std::optional<Record::Pending> pending_of(const json::object& object) {
  constexpr State kStates[] = {State::kApplying, State::kWaiting, State::kSettling,
                               State::kGoingBack};
  const std::string name = text_at(object, "pending.state");
  for (const State state : kStates)
    if (name == name_of(state))
      return Record::Pending{.generation = number_of(object, "pending.generation"),
                             .state = state,
                             .reason = text_at(object, "pending.reason")};
  return std::nullopt;
}

}  // namespace

json::object to_json(const Item& item) {
  return {{"generation", item.generation},
          {"from", item.from},
          {"change", item.change},
          {"who", item.who},
          {"why", item.why},
          {"time", item.time},
          {"outcome", name_of(item.outcome)},
          {"reason", item.reason},
          {"others", texts(item.others)}};
}

json::object to_json(const Record& record) {
  json::object object{{"current", record.current}, {"last", record.last}};
  if (record.pending)
    object["pending"] = json::object{{"generation", record.pending->generation},
                                     {"state", name_of(record.pending->state)},
                                     {"reason", record.pending->reason}};
  json::array& items = item_array(object);
  for (const Item& item : record.items) items.push_back(to_json(item));
  json::object untold;
  for (const auto& [change, agents] : record.untold) untold[change] = texts(agents);
  object["untold"] = std::move(untold);
  return object;
}

std::optional<Record> record_of(const json::value& value) {
  const json::object* object = value.if_object();
  if (object == nullptr) return std::nullopt;
  Record record{.current = number_of(*object, "current"), .last = number_of(*object, "last")};
  for (const json::value& each : items_of(*object)) {
    auto item = item_of(each);
    if (!item) return std::nullopt;
    record.items.push_back(std::move(*item));
  }
  if (at_path(*object, "pending") != nullptr) {
    record.pending = pending_of(*object);
    const Item* made = record.pending ? record.find(record.pending->generation) : nullptr;
    if (made == nullptr) return std::nullopt;
  }
  if (const json::value* untold = at_path(*object, "untold");
      untold != nullptr && untold->is_object())
    for (const auto& [change, agents] : untold->get_object())
      record.untold[std::string(change)] = texts_of(untold->get_object(), change);
  return record;
}

Store::Store(std::string path) : path_(std::move(path)) {
  std::error_code error;
  fs::create_directories(path_, error);
}

std::string Store::path_of(Generation generation) const {
  return fmt::format("{}/generation-{}.json", path_, generation);
}

tims::Result<Record> Store::load() const {
  const std::string path = path_ + "/record.json";
  if (!fs::exists(path)) return Record{};
  const auto text = tims::os::read_file(path, kStoredMax);
  if (!text) return text.error();
  boost::system::error_code error;
  const json::value value = json::parse(*text, error);
  auto record = error ? std::nullopt : record_of(value);
  if (!record) return tims::Error(tims::Errc::kMalformed, path + ": is not the record of an agent");
  return std::move(*record);
}

tims::Result<void> Store::save(const Record& record) const {
  auto done =
      tims::os::replace_file(path_ + "/record.json", json::serialize(to_json(record)), kMode);
  if (done) forget(record);
  return done;
}

tims::Result<Texts> Store::files(Generation generation) const {
  const auto text = tims::os::read_file(path_of(generation), kStoredMax);
  if (!text) return text.error();
  boost::system::error_code error;
  const json::value value = json::parse(*text, error);
  const json::object* all = error ? nullptr : value.if_object();
  if (all == nullptr)
    return tims::Error(tims::Errc::kMalformed, path_of(generation) + ": is not a generation");
  Texts files;
  for (const auto& [name, content] : *all)
    if (is_file_name(name) && content.is_string())
      files.emplace(std::string(name), std::string(content.get_string()));
  return files;
}

tims::Result<void> Store::keep(Generation generation, const Texts& files) const {
  json::object all;
  for (const auto& [name, text] : files) all[name] = text;
  return tims::os::replace_file(path_of(generation), json::serialize(all), kMode);
}

void Store::forget(const Record& record) const {
  constexpr std::string_view kPrefix = "generation-";
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path_, error)) {
    const std::string name = entry.path().stem();
    if (!name.starts_with(kPrefix)) continue;
    const auto number =
        base::parse_number<Generation>(std::string_view(name).substr(kPrefix.size()));
    // Greater ones are being written.
    if (number && *number <= record.last && record.find(*number) == nullptr)
      fs::remove(entry.path(), error);
  }
}

}  // namespace timsctl::configuration
