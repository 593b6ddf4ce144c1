#include "components/geometry/dxf_entity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <span>

#include "base/text.h"
#include "components/geometry/dxf.h"

namespace rack {

namespace {

constexpr int kMesh = 16 | 64;  // flags of POLYLINE: its vertices do not form a line

template <typename T>
std::optional<T> dxf_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  return tims::base::parse_number<T>(text);
}

bool begins_entity(const DxfGroup& group) {
  return group.code == 0 || (group.code == 9 && group.value.starts_with('$'));
}

bool is_kept(int code) {
  return (code > 0 && code < 100 && code != 9) || code == 210 || code == 220 || code == 230;
}

bool is_real(int code) { return (code >= 10 && code < 60) || code >= 210; }

// The groups without which an entity is not complete.
struct Needed {
  std::string_view type;
  std::array<int, 5> codes;  // 0: no more
  const char* fault;
};

constexpr std::array<Needed, 9> kNeeded = {
    Needed{"LINE", {10, 20, 11, 21}, "without an end"},
    Needed{"POINT", {10, 20}, "without coordinates"},
    Needed{"VERTEX", {10, 20}, "without coordinates"},
    Needed{"CIRCLE", {10, 20, 40}, "without centre or radius"},
    Needed{"ARC", {10, 20, 40, 50, 51}, "without centre, radius or angles"},
    Needed{"ELLIPSE", {10, 20, 11, 21, 40}, "without centre, axis or ratio"},
    Needed{"INSERT", {2, 10, 20}, "without the name of a block or coordinates"},
    Needed{"BLOCK", {2}, "without a name"},
    Needed{"LAYER", {2}, "without a name"},
};

std::string fault_of_polyline(const DxfEntity& entity) {
  const std::size_t vertices = entity.count(10);
  if (entity.count(90) > 0 && !std::cmp_equal(entity.number(90, -1), vertices))
    return "has a wrong number of vertices";
  if (entity.count(20) != vertices) return "has a vertex without coordinates";
  if (vertices == 0) return "without vertices";
  if (vertices > DxfEntity::kVerticesMax) return "has more than 20000 vertices";
  return {};
}

}  // namespace

std::size_t DxfEntity::count(int code) const {
  return static_cast<std::size_t>(std::ranges::count(groups, code, &DxfGroup::code));
}

std::string_view DxfEntity::value(int code) const {
  for (std::size_t i = groups.size(); i-- > 0;)
    if (groups[i].code == code) return groups[i].value;
  return {};
}

int DxfEntity::number(int code, int otherwise) const {
  return dxf_number<int>(value(code)).value_or(otherwise);
}

std::string DxfEntity::fault() const {
  if (is_too_long || groups.size() > kGroupsMax) return "is too long";
  for (const DxfGroup& group : groups) {
    if (group.value.size() > kValueMax) return "has a value of more than 1000 characters";
    if (!is_real(group.code)) continue;
    const auto number = dxf_number<double>(group.value);
    if (!number || !(std::abs(*number) <= DxfDrawing::kFarthest))
      return "a coordinate is not a number";
  }
  if (type == "LWPOLYLINE") return fault_of_polyline(*this);
  if (type == "POLYLINE" && (number(70, 0) & kMesh) != 0) return "is a mesh";
  for (const Needed& needed : kNeeded) {
    if (needed.type != type) continue;
    for (const int code : needed.codes)
      if (code != 0 && value(code).empty()) return needed.fault;
  }
  return {};
}

// dxflib needs the number of vertices before the first one, and nothing of a vertex before that.
std::string DxfEntity::text() const {
  const bool counts = type == "LWPOLYLINE";
  std::string text = type.starts_with('$') ? "9\n" : "0\n";
  const auto add = [&](int code, std::string_view value) {
    (text += std::to_string(code)) += '\n';
    (text += value) += '\n';
  };
  (text += type) += '\n';
  if (counts) add(90, std::to_string(count(10)));
  bool has_vertex = false;
  for (const auto& [code, value] : groups) {
    has_vertex = has_vertex || code == 10;
    if (counts && (code == 90 || (!has_vertex && (code == 20 || code == 30 || code == 42))))
      continue;
    add(code, value);
  }
  return text;
}

std::string_view DxfEntities::take_line() {
  const auto end = left_.find('\n');
  const std::string_view line = left_.substr(0, end);
  left_.remove_prefix(end == std::string_view::npos ? left_.size() : end + 1);
  ++line_;
  return tims::base::trimmed(line);
}

tims::Result<std::optional<DxfEntities::Pair>> DxfEntities::next_pair() {
  if (left_.find_first_not_of(" \t\r\n") == std::string_view::npos) return {std::nullopt};
  const std::string_view code = take_line();
  Pair pair{.group = {}, .line = line_};
  const auto at = [&](const char* what) {
    return tims::Error(tims::Errc::kMalformed, "line " + std::to_string(pair.line) + ": " + what);
  };
  const auto parsed = dxf_number<int>(code);
  if (!parsed) return at("no group code");
  if (left_.empty()) return at("a group code without value");
  pair.group = {*parsed, take_line()};
  return {pair};
}

tims::Result<std::optional<DxfEntity>> DxfEntities::next() {
  std::optional<DxfEntity> entity;
  if (begun_) entity = {.type = begun_->group.value, .line = begun_->line};
  begun_.reset();
  for (;;) {
    const auto pair = next_pair();
    if (!pair) return pair.error();
    if (!*pair) return {std::move(entity)};
    const DxfGroup& group = (*pair)->group;
    if (begins_entity(group)) {
      const bool is_end = group.code == 0 && group.value == "EOF";
      if (is_end) left_ = {};
      if (!is_end) begun_ = **pair;
      if (entity || is_end) return {std::move(entity)};
      entity = {.type = group.value, .line = (*pair)->line};
      begun_.reset();
      continue;
    }
    if (!entity || !is_kept(group.code)) continue;
    if (entity->groups.size() == DxfEntity::kGroupsMax) entity->is_too_long = true;
    if (!entity->is_too_long) entity->groups.push_back(group);
  }
}

}  // namespace rack
