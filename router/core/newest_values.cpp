#include "router/core/newest_values.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "router/core/random.h"

namespace tims::core {
namespace {

// The newest sample of these describes what is; one of a scanner, a camera or a stick is soon of no
// use.
constexpr std::array<std::uint32_t, 17> kStateClasses{
    class_id::kChassis, class_id::kOdometry,   class_id::kPosition, class_id::kGps,
    class_id::kPilot,   class_id::kObjRecog,   class_id::kClock,    class_id::kVehicle,
    class_id::kIo,      class_id::kServoDrive, class_id::kPlanner,  class_id::kFeatureMap,
    class_id::kGridMap, class_id::kPath,       class_id::kMcl,      class_id::kPtzDrive,
    class_id::kCompass};

StreamKind stream_kind_of(std::int8_t message_type) {
  if (message_type == type::kData) return StreamKind::kData;
  return message_type == type::kParam ? StreamKind::kParameters : StreamKind::kStatus;
}

}  // namespace

std::string_view name(StreamKind kind) { return label(kStreamKinds, kind).name; }

bool NewestRule::add(std::string_view element) {
  if (element == "status") return status = true;
  if (element == "parameters") return parameters = true;
  if (element == "state") {
    for (const std::uint32_t id : kStateClasses) classes.set(id);
    return true;
  }
  if (element == "*") {
    classes.set();
    return true;
  }
  const std::optional<std::uint32_t> id = class_id_of(element);
  if (!id || *id >= kClassIds) return false;
  classes.set(*id);
  return true;
}

NewestValues::NewestValues(std::size_t bytes, HashSeed seed)
    : seed_(seed),
      cell_count_(std::min<std::size_t>(bytes / kCellBytes, kNone)),
      cells_(std::make_unique_for_overwrite<Cell[]>(cell_count_)),
      entries_max_(std::max<std::size_t>(cell_count_ * kCellBytes / kBytesPerValue, 1)),
      buckets_(std::bit_ceil(entries_max_), kNone) {
  entries_.reserve(entries_max_);
  counts_.bytes_max = cell_count_ * kCellBytes;
}

void NewestValues::keep(Time now, const Message& message) {
  const Header& header = message.header;
  const std::size_t cells = cells_for(message.body().size());
  if (message.bytes.size() > rule_.length_max || cells > cell_count_) {
    ++counts_.too_big;
    return;
  }
  const StreamKind kind = stream_kind_of(header.type);
  Index index = find_entry(header.src, kind);
  if (index == kNone) {
    index = add_entry(header.src, kind);
    ++counts_.added;
  } else {
    release_cells(entries_[index]);
    unlink(index);
    ++counts_.replaced;
  }
  // Linked only afterwards: it is not among those that make room for it.
  while (free_cells() < cells) evict_oldest();
  link_newest(index);
  Entry& entry = entries_[index];
  entry.value = {header, kind, now, entry.value.samples + 1};
  entry.value.header.length = static_cast<std::uint32_t>(message.bytes.size());
  store(entry, message.body());
}

const NewestValues::Value* NewestValues::find(Address source, StreamKind kind) const {
  const Index index = find_entry(source, kind);
  return index == kNone ? nullptr : &entries_[index].value;
}

std::vector<std::byte> NewestValues::body(const Value& value) const {
  std::vector<std::byte> bytes(value.header.body_size());
  std::span<std::byte> rest(bytes);
  const Index entry = find_entry(value.header.src, value.kind);
  for (Index i = entries_[entry].cells; !rest.empty(); i = cells_[i].next) {
    const std::size_t n = std::min(rest.size(), kCellBodyBytes);
    std::copy_n(cells_[i].data, n, rest.begin());
    rest = rest.subspan(n);
  }
  return bytes;
}

std::vector<const NewestValues::Value*> NewestValues::sorted(const AddressPattern& match) const {
  std::vector<const Value*> found;
  for (Index i = oldest_; i != kNone; i = entries_[i].newer)
    if (match.matches(entries_[i].value.header.src)) found.push_back(&entries_[i].value);
  std::ranges::sort(found, {}, [](const Value* value) {
    return std::pair(value->header.src.raw(), value->kind);
  });
  return found;
}

// --- entries

std::size_t NewestValues::bucket(Address source, StreamKind kind) const {
  const std::uint64_t key = std::uint64_t{source.raw()} << 8 | static_cast<std::uint8_t>(kind);
  return sip_hash({seed_.first, seed_.second}, {key}) & (buckets_.size() - 1);
}

NewestValues::Index NewestValues::find_entry(Address source, StreamKind kind) const {
  Index i = buckets_[bucket(source, kind)];
  while (i != kNone && (entries_[i].value.header.src != source || entries_[i].value.kind != kind))
    i = entries_[i].next;
  return i;
}

NewestValues::Index NewestValues::add_entry(Address source, StreamKind kind) {
  if (counts_.values == entries_max_) evict_oldest();
  Index index = free_entry_;
  if (index == kNone) {
    index = static_cast<Index>(entries_.size());
    entries_.emplace_back();
  } else {
    free_entry_ = entries_[index].next;
    entries_[index] = {};
  }
  Index& first = buckets_[bucket(source, kind)];
  entries_[index].next = std::exchange(first, index);
  ++counts_.values;
  return index;
}

// Precondition: there is one that is linked.
void NewestValues::evict_oldest() {
  const Index index = oldest_;
  Entry& entry = entries_[index];
  Index* at = &buckets_[bucket(entry.value.header.src, entry.value.kind)];
  while (*at != index) at = &entries_[*at].next;
  *at = entry.next;
  release_cells(entry);
  unlink(index);
  entry.next = std::exchange(free_entry_, index);
  --counts_.values;
  ++counts_.evicted;
}

void NewestValues::link_newest(Index index) {
  entries_[index].older = newest_;
  entries_[index].newer = kNone;
  (newest_ == kNone ? oldest_ : entries_[newest_].newer) = index;
  newest_ = index;
}

void NewestValues::unlink(Index index) {
  const Entry& entry = entries_[index];
  (entry.older == kNone ? oldest_ : entries_[entry.older].newer) = entry.newer;
  (entry.newer == kNone ? newest_ : entries_[entry.newer].older) = entry.older;
}

// --- cells

// Precondition: there are enough free cells.
void NewestValues::store(Entry& entry, std::span<const std::byte> body) {
  counts_.bytes += body.size();
  Index* end = &entry.cells;
  while (!body.empty()) {
    const Index index = free_cell_ == kNone ? static_cast<Index>(cells_touched_++)
                                            : std::exchange(free_cell_, cells_[free_cell_].next);
    ++cells_used_;
    const std::size_t n = std::min(body.size(), kCellBodyBytes);
    std::copy_n(body.begin(), n, cells_[index].data);
    body = body.subspan(n);
    *end = index;
    end = &cells_[index].next;
  }
  *end = kNone;
}

void NewestValues::release_cells(Entry& entry) {
  counts_.bytes -= entry.value.header.body_size();
  while (entry.cells != kNone) {
    const Index index = std::exchange(entry.cells, cells_[entry.cells].next);
    cells_[index].next = std::exchange(free_cell_, index);
    --cells_used_;
  }
}

}  // namespace tims::core
