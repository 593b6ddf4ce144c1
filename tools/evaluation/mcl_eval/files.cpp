#include "tools/evaluation/mcl_eval/files.h"

#include <cstdio>
#include <ctime>

#include "components/position/map_file.h"
#include "os/file.h"

namespace rack::mcl_eval {

using timsctl::Exit;
using timsctl::Failure;

std::string read_file(const std::string& name) {
  auto bytes = tims::os::read_file(name);
  if (!bytes) throw Failure(Exit::kNoSuch, "no_such_file", bytes.error().detail());
  if (bytes->starts_with("\xFD"
                         "7zXZ"))
    throw Failure(Exit::kNo, "bad_file", fmt::format("{}: the file is compressed", name),
                  "unpack it: xz -dk FILE");
  return std::move(bytes).value();
}

localisation::GridMap read_map(const std::string& name) {
  auto map = navigation::load_map(name, {.scale = 0, .scale_otherwise = 1000});
  if (!map)
    throw Failure(map.error() == tims::Errc::kMalformed ? Exit::kNo : Exit::kNoSuch, "bad_file",
                  map.error().detail());
  for (const std::string& remark : map->remarks) fmt::print(stderr, "{}\n", remark);
  return std::move(map->map);
}

localisation::LikelihoodField field_of(const localisation::GridMap& map, const std::string& file) {
  return well(localisation::LikelihoodField::of(map, {}), file);
}

double stopwatch_us() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e6 + static_cast<double>(time.tv_nsec) / 1e3;
}

std::string line_of(const std::vector<Field>& fields, bool json) {
  std::string line;
  for (const Field& field : fields) {
    if (!line.empty()) line += json ? "," : " ";
    line += json ? fmt::format("\"{}\":{:.{}f}", field.name, field.value, field.digits)
                 : fmt::format("{}={:.{}f}", field.name, field.value, field.digits);
  }
  return line;
}

void print_line(const std::vector<Field>& fields, bool json) {
  const std::string line = line_of(fields, json);
  fmt::print("{}\n", json ? "{" + line + "}" : line);
  std::fflush(stdout);
}

}  // namespace rack::mcl_eval
