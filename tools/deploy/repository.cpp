#include "tools/deploy/repository.h"

#include <algorithm>
#include <map>
#include <set>

#include "base/text.h"

namespace timsctl::deploy {
namespace {

namespace base = tims::base;

// "libc6 (>= 2.36), a | b:any" -> libc6, a, b
void add_needs(std::string_view list, std::vector<std::string>& needs) {
  while (!list.empty()) {
    std::string_view one = list.substr(0, list.find_first_of(",|"));
    list.remove_prefix(std::min(one.size() + 1, list.size()));
    one = base::trimmed(one);
    one = one.substr(0, one.find_first_of(" (:["));
    if (!one.empty()) needs.emplace_back(one);
  }
}

bool is_plain(std::string_view file) {
  return !file.empty() && file.size() <= 200 && file.front() != '.' && file.front() != '-' &&
         std::ranges::all_of(file, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  std::string_view("._+~%-").find(c) != std::string_view::npos;
         });
}

void read_field(std::string_view line, Package& package) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || line.front() == ' ') return;
  const std::string_view name = line.substr(0, colon);
  const std::string_view value = base::trimmed(line.substr(colon + 1));
  if (name == "Package") package.name = value;
  if (name == "Version") package.version = value;
  if (name == "Architecture") package.architecture = value;
  if (name == "SHA256") package.sha256 = value;
  if (name == "Depends" || name == "Pre-Depends") add_needs(value, package.needs);
  if (name == "Size") package.size = base::parse_number<std::uint64_t>(value).value_or(0);
  if (name == "Filename") package.file = value.substr(value.starts_with("./") ? 2 : 0);
}

// The order of characters in a version: ~ before the end, letters before the rest.
int weight(char c) {
  if (c == '~') return -1;
  if (c >= '0' && c <= '9') return 0;
  const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  return is_letter ? c : c + 256;
}

bool is_digit(std::string_view text) { return !text.empty() && text[0] >= '0' && text[0] <= '9'; }

std::string_view take_number(std::string_view& text) {
  while (text.starts_with('0')) text.remove_prefix(1);
  std::size_t n = 0;
  while (is_digit(text.substr(n))) ++n;
  const std::string_view number = text.substr(0, n);
  text.remove_prefix(n);
  return number;
}

int compare_part(std::string_view a, std::string_view b) {
  while (!a.empty() || !b.empty()) {
    while ((!a.empty() && !is_digit(a)) || (!b.empty() && !is_digit(b))) {
      const int left = a.empty() ? 0 : weight(a[0]);
      const int right = b.empty() ? 0 : weight(b[0]);
      if (left != right) return left - right;
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
    const std::string_view left = take_number(a);
    const std::string_view right = take_number(b);
    if (left.size() != right.size()) return left.size() < right.size() ? -1 : 1;
    if (const int order = left.compare(right); order != 0) return order;
  }
  return 0;
}

// The part behind the last hyphen, which is taken off; "0" without one.
std::string_view take_revision(std::string_view& version) {
  const std::size_t hyphen = version.rfind('-');
  if (hyphen == std::string_view::npos) return "0";
  const std::string_view revision = version.substr(hyphen + 1);
  version = version.substr(0, hyphen);
  return revision;
}

std::string_view take_epoch(std::string_view& version) {
  const std::size_t colon = version.find(':');
  if (colon == std::string_view::npos) return "0";
  const std::string_view epoch = version.substr(0, colon);
  version.remove_prefix(colon + 1);
  return epoch;
}

}  // namespace

std::vector<Package> packages_in(std::string_view index) {
  std::vector<Package> all;
  while (!index.empty()) {
    const std::size_t end = std::min(index.find("\n\n"), index.size());
    Package package{.paragraph = std::string(index.substr(0, end))};
    index.remove_prefix(std::min(end + 2, index.size()));
    for (std::string_view rest = package.paragraph; !rest.empty();) {
      const std::string_view line = rest.substr(0, rest.find('\n'));
      rest.remove_prefix(std::min(line.size() + 1, rest.size()));
      if (!line.empty()) read_field(line, package);
    }
    if (!package.name.empty() && !package.version.empty() && is_plain(package.file) &&
        package.sha256.size() == 64 && package.size > 0)
      all.push_back(std::move(package));
  }
  return all;
}

int compare_versions(std::string_view a, std::string_view b) {
  if (const int order = compare_part(take_epoch(a), take_epoch(b)); order != 0) return order;
  const std::string_view a_revision = take_revision(a);
  const std::string_view b_revision = take_revision(b);
  if (const int order = compare_part(a, b); order != 0) return order;
  return compare_part(a_revision, b_revision);
}

std::vector<Package> needed(std::span<const Package> all, std::span<const std::string> wanted,
                            std::string_view architecture) {
  std::map<std::string, const Package*, std::less<>> newest;
  for (const Package& package : all) {
    if (package.architecture != architecture && package.architecture != "all") continue;
    const Package*& known = newest[package.name];
    if (known == nullptr || compare_versions(known->version, package.version) < 0) known = &package;
  }
  std::vector<std::string> open(wanted.begin(), wanted.end());
  std::set<std::string> seen(open.begin(), open.end());
  std::vector<Package> found;
  while (!open.empty()) {
    const auto known = newest.find(open.back());
    open.pop_back();
    if (known == newest.end()) continue;
    found.push_back(*known->second);
    for (const std::string& name : known->second->needs)
      if (seen.insert(name).second) open.push_back(name);
  }
  std::ranges::sort(found, {}, &Package::name);
  return found;
}

}  // namespace timsctl::deploy
