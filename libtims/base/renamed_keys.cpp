#include "base/renamed_keys.h"

#include <algorithm>
#include <string>

namespace tims::base {
namespace {

constexpr RenamedKey kRenamed[] = {
    {"component[].parameters.reflectorFilter", "Scan2d", "reflectorFilterMode", "0.2"},
    {"robot[].slip.way", "", "distance", "0.2"},
    {"robot[].slip.way_noise", "", "distance_noise", "0.2"},
};

constexpr std::string_view kEach = "[]";

TomlNode* child(TomlNode& node, std::string_view key) {
  const auto found = std::ranges::find(node.children, key, &TomlNode::key);
  return found == node.children.end() ? nullptr : &*found;
}

bool is_of_program(TomlNode& element, std::string_view program) {
  if (program.empty()) return true;
  const TomlNode* named = child(element, "program");
  const auto* text = named == nullptr ? nullptr : std::get_if<std::string>(&named->value);
  return text != nullptr && text->substr(text->rfind('/') + 1) == program;
}

struct Found {
  TomlPath path;
  TomlNode* table = nullptr;
  TomlNode* node = nullptr;
};

// Walks along a row's path; each [] branches.
void find(const RenamedKey& row, std::string_view rest, TomlNode& node, const TomlPath& path,
          std::vector<Found>& all) {
  const std::string_view step = rest.substr(0, rest.find('.'));
  rest.remove_prefix(std::min(rest.size(), step.size() + 1));
  const bool is_each = step.ends_with(kEach);
  const std::string key(step.substr(0, step.size() - (is_each ? kEach.size() : 0)));
  TomlNode* next = node.form == TomlNode::Form::kTable ? child(node, key) : nullptr;
  if (next == nullptr) return;
  TomlPath at = path;
  at.emplace_back(key);
  if (rest.empty()) return all.push_back({.path = std::move(at), .table = &node, .node = next});
  if (!is_each) return find(row, rest, *next, at, all);
  if (!next->is_array_of_tables()) return;
  for (std::size_t i = 0; i < next->children.size(); ++i) {
    TomlNode& element = next->children[i];
    if (!is_of_program(element, row.program)) continue;
    TomlPath of_element = at;
    of_element.emplace_back(i);
    find(row, rest, element, of_element, all);
  }
}

std::vector<Found> found_in(TomlTree& tree, const RenamedKey& row) {
  std::vector<Found> all;
  find(row, row.path, tree.root, {}, all);
  return all;
}

Problem hint_of(const TomlNode& node, const RenamedKey& row) {
  return {node.at_key, node.key + " is called " + std::string(row.name) + " since " +
                           std::string(row.since) +
                           ", and is understood until the next minor version: `timsctl config "
                           "migrate` rewrites it"};
}

}  // namespace

std::span<const RenamedKey> renamed_keys() { return kRenamed; }

TomlPath FormerKey::path_now() const {
  TomlPath now = path;
  now.back() = std::string(renamed->name);
  return now;
}

TomlOperation FormerKey::renaming() const {
  return {.kind = TomlOperation::Kind::kRename, .path = path, .name = std::string(renamed->name)};
}

std::vector<FormerKey> former_keys(const TomlTree& tree) {
  TomlTree searched = tree;
  std::vector<FormerKey> all;
  for (const RenamedKey& row : kRenamed)
    for (Found& found : found_in(searched, row))
      all.push_back(
          {.path = std::move(found.path), .renamed = &row, .hint = hint_of(*found.node, row)});
  return all;
}

std::vector<Problem> rename_former_keys(TomlTree& tree) {
  std::vector<Problem> hints;
  for (const RenamedKey& row : kRenamed)
    for (const Found& found : found_in(tree, row)) {
      if (child(*found.table, row.name) != nullptr) continue;
      hints.push_back(hint_of(*found.node, row));
      found.node->key = row.name;
    }
  return hints;
}

TomlEdited migrated(const TextFile& file) {
  std::vector<TomlOperation> operations;
  for (const FormerKey& former : former_keys(parse_toml(file)))
    operations.push_back(former.renaming());
  return edited_toml(file, operations);
}

}  // namespace tims::base
