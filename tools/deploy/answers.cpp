#include "tools/deploy/answers.h"

#include <algorithm>
#include <array>

#include "base/text.h"

namespace timsctl::deploy {
namespace {

namespace base = tims::base;

constexpr std::size_t kWordMax = 200;

bool is_digest(std::string_view text) {
  return text.size() == 64 && std::ranges::all_of(text, [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

// Names and versions of packages, names of files: one printable word.
bool is_word(std::string_view text) {
  return !text.empty() && text.size() <= kWordMax &&
         std::ranges::all_of(text, [](char c) { return c > ' ' && c < 0x7F; });
}

// The first word, which is taken off.
std::string_view take_word(std::string_view& line) {
  const std::string_view word = line.substr(0, line.find(' '));
  line.remove_prefix(std::min(word.size() + 1, line.size()));
  return word;
}

// each(what, rest) for every line.
template <typename Each>
void for_lines(std::string_view text, Each each) {
  text = text.substr(0, kAnswerMax);
  while (!text.empty()) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::string_view what = take_word(line);
    each(what, line);
  }
}

void read_file(std::string_view rest, Facts& facts) {
  const std::string_view name = take_word(rest);
  const std::string_view digest = take_word(rest);
  if (!is_deployed_name(name) || !is_digest(digest)) return;
  HostFile file{.sha256 = std::string(digest), .text = {}};
  if (const auto bytes = base::parse_hex(rest); bytes && rest != "-")
    file.text = std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  facts.files[std::string(name)] = std::move(file);
}

}  // namespace

Facts facts_of(std::string_view answer) {
  Facts facts;
  for_lines(answer, [&](std::string_view what, std::string_view rest) {
    if (what == "end") facts.complete = true;
    if (what == "undo") facts.can_undo = true;
    if (what == "phase") facts.interrupted = true;
    if (what == "arch" && is_word(rest)) facts.architecture = rest;
    if (what == "file") read_file(rest, facts);
    const std::string_view first = take_word(rest);
    if (what == "package") {
      const std::string_view version = take_word(rest);
      if (is_word(first) && is_word(version) && rest.starts_with("ii"))
        facts.packages[std::string(first)] = version;
    }
    if (what != "deployed" && what != "deb") return;
    const std::string_view name = base::trimmed(rest);  // sha256sum writes two blanks
    if (!is_digest(first) || !is_word(name)) return;
    (what == "deb" ? facts.debs : facts.deployed)[std::string(name)] = first;
  });
  return facts;
}

std::vector<PackageChange> changes_of(std::string_view answer) {
  std::vector<PackageChange> changes;
  const auto version = [](std::string_view word) { return std::string(word == "-" ? "" : word); };
  for_lines(answer, [&](std::string_view what, std::string_view rest) {
    if (what != "install") return;
    const std::string_view name = take_word(rest);
    const std::string_view before = take_word(rest);
    if (is_word(name) && is_word(before) && is_word(rest))
      changes.push_back({std::string(name), version(before), version(rest)});
  });
  return changes;
}

Progress progress_of(std::string_view answer) {
  Progress progress;
  for_lines(answer, [&](std::string_view what, std::string_view rest) {
    if (what == "step") progress.steps.push_back(base::printable(rest.substr(0, kWordMax)));
    if (what == "log") progress.log.push_back(base::printable(rest.substr(0, kWordMax)));
    if (what != "result") return;
    const std::string_view end = take_word(rest);
    constexpr std::array<std::pair<std::string_view, End>, 4> kEnds{{{"kept", End::kKept},
                                                                     {"same", End::kSame},
                                                                     {"back", End::kWentBack},
                                                                     {"broken", End::kBroken}}};
    for (const auto& [name, value] : kEnds)
      if (end == name) progress.end = value;
    progress.reason = base::printable(rest.substr(0, 2 * kWordMax));
  });
  return progress;
}

std::string reason_in(std::string_view errors) {
  constexpr std::string_view kOurs = "tims-deploy: ";
  std::string_view last;
  std::string_view ours;
  for (std::string_view rest = errors; !rest.empty();) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    if (line.starts_with(kOurs)) ours = line.substr(kOurs.size());
    if (!base::trimmed(line).empty()) last = base::trimmed(line);
  }
  return base::printable((ours.empty() ? last : ours).substr(0, 2 * kWordMax));
}

bool is_deployed_name(std::string_view name) {
  if (name == "router.toml") return true;
  const std::size_t slash = name.find('/');
  if (slash == std::string_view::npos) return false;
  const std::string_view folder = name.substr(0, slash);
  const std::string_view file = name.substr(slash + 1);
  constexpr std::string_view kOthers = "._-";
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  return (folder == "router.d" || folder == "robots" || folder == "keys") && !file.empty() &&
         file.size() <= 64 && is_letter(file.front()) && std::ranges::all_of(file, [&](char c) {
           return is_letter(c) || kOthers.find(c) != std::string_view::npos;
         });
}

}  // namespace timsctl::deploy
