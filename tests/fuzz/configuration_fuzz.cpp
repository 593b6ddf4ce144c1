// What an agent of configuration reads from others: records, descriptions, robot files and router
// files of a fleet, whatever their texts are. A record that is read is written in the same form.
#include <boost/json/parse.hpp>

#include "tests/fuzz/fuzz_input.h"
#include "tools/configuration/differences.h"
#include "tools/configuration/effects.h"
#include "tools/configuration/fleet.h"
#include "tools/configuration/store.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace timsctl::configuration;
  namespace json = boost::json;
  tims::fuzz::Input input(data, size);
  const std::string text(input.text());
  // Three parts, divided by zero bytes: JSON, a robot file, a router file.
  const std::size_t first = std::min(text.find('\0'), text.size());
  const std::size_t second = std::min(text.find('\0', first + 1), text.size());
  const std::string robot = text.substr(std::min(first + 1, text.size()), second - first);
  const std::string router = text.substr(std::min(second + 1, text.size()));
  boost::system::error_code error;
  const json::value value = json::parse(text.substr(0, first), error);
  std::optional<Description> description;
  if (!error) {
    if (const auto record = record_of(value)) {
      const auto again = record_of(to_json(*record));
      tims::fuzz::require(again && *again == *record);
      HostChange change({}, *record);
      while (change.step() != nullptr) change.done({});
      tims::fuzz::require(change.record().find(0) == nullptr);
    }
    if (const json::object* object = value.if_object()) description = description_of(*object);
  }
  const Describe describe = [&](const std::string&) -> const Description* {
    return description ? &*description : nullptr;
  };
  const Surroundings around{
      .describe = describe,
      .has_file = [](const std::string&) { return false; },
      .files_beside = [](const std::string&) { return std::vector<std::string>{}; }};
  for (const Finding& finding : check_robot({"robots/r.toml", robot}, around))
    tims::fuzz::require(!finding.text.empty());
  tims::fuzz::use(robot_difference(robot, router, "robots/r.toml", describe));
  tims::fuzz::use(difference("f", robot, router));
  FleetHost host{.name = "a", .robots = {{.name = "robots/r.toml", .text = robot}}};
  const auto loaded = load_router({{"router.toml", router}});
  if (loaded.ok()) host.router = loaded.config;
  FleetHost other = host;
  other.name = std::string("b");  // g++ 12 warns wrongly of "b"
  tims::fuzz::require(check_fleet({host, other}, describe).order.size() == 2);
  return 0;
}
