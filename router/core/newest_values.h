// The newest value of every stream that describes a state and passed this router: who comes late
// gets it at once, with its age, also when its source is away.
//
// A stream is what one source sends of one kind (StreamKind). Which streams are kept is a rule
// (NewestRule); the memory is allocated once and divided into cells, a value is a list of cells.
// When there is no room, the values that were not renewed for the longest time are evicted. A
// message that is not kept costs a look at its type. Pure.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "router/core/table.h"
#include "router/core/types.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

enum class StreamKind : std::uint8_t {
  kData,        // DATA to listeners (kOfStream)
  kStatus,      // replies ENABLED and DISABLED to GET_STATUS
  kParameters,  // replies PARAM to GET_PARAM and SET_PARAM
};
inline constexpr std::size_t kStreamKindCount = 3;
constexpr std::array kStreamKinds{
    Label<StreamKind>{StreamKind::kData, "data", "samples of a data stream"},
    Label<StreamKind>{StreamKind::kStatus, "status", "whether the component is on"},
    Label<StreamKind>{StreamKind::kParameters, "parameters", "all parameters of the component"},
};
static_assert(complete(kStreamKinds, StreamKind::kParameters) &&
              kStreamKinds.size() == kStreamKindCount);
std::string_view name(StreamKind kind);

// Which messages are kept.
struct NewestRule {
  static constexpr std::size_t kClassIds = 256;

  bool status = false;
  bool parameters = false;
  std::bitset<kClassIds> classes{};  // of sources of data
  std::uint32_t length_max = 0;      // bytes, header included
  AddressWidths widths{};

  // Reads one element of a list: "status", "parameters", "state" for the data of the classes that
  // describe a state, the name of a class, or "*" for the data of all classes. False: it is none
  // of these.
  bool add(std::string_view element);
};

class NewestValues {
 public:
  static constexpr std::size_t kCellBytes = 256;
  static constexpr std::size_t kBytesPerValue = 1024;  // so many values have room on average
  // Data to a listener have one of these flags: samples of which the newest is enough, and those
  // that must all arrive, such as the distances that a chassis has driven. Answers to GET_DATA,
  // which may be older, have none.
  static constexpr std::uint8_t kOfStream = flag::kStream | flag::kReportIfGone;

  // Allocates `bytes` for bodies, and room for one value for each kBytesPerValue of them.
  NewestValues(std::size_t bytes, HashSeed seed);

  // Values that are there stay.
  void set_rule(const NewestRule& rule) { rule_ = rule; }

  [[nodiscard]] bool wants(const Header& header) const {
    switch (header.type) {
      case type::kData:
        return (header.flags & kOfStream) != 0 && has_class(header.src);
      case type::kEnabled:
      case type::kDisabled:
        return rule_.status;
      case type::kParam:
        return rule_.parameters;
      default:
        return false;
    }
  }
  // Preconditions: wants() it, and its sender owns its source address.
  void keep(Time now, const Message& message);

  struct Value {
    Header header{};  // of the message
    StreamKind kind = StreamKind::kData;
    Time at{};                  // when it passed
    std::uint64_t samples = 0;  // of this stream since it was first kept
  };
  // Null: nothing is kept of this stream. Valid until the next keep().
  [[nodiscard]] const Value* find(Address source, StreamKind kind) const;
  [[nodiscard]] std::vector<std::byte> body(const Value& value) const;
  // Of the sources that match, in order of their addresses and kinds. Allocates.
  [[nodiscard]] std::vector<const Value*> sorted(const AddressPattern& match) const;

  struct Counts {
    std::uint64_t values = 0;     // kept now
    std::uint64_t bytes = 0;      // of their bodies
    std::uint64_t bytes_max = 0;  // of memory
    std::uint64_t added = 0;      // streams that were new
    std::uint64_t replaced = 0;   // values by newer ones
    std::uint64_t evicted = 0;    // values for others
    std::uint64_t too_big = 0;    // messages that were not kept
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  using Index = std::uint32_t;
  static constexpr Index kNone = 0xFFFFFFFF;
  struct Cell {
    Index next;
    std::byte data[kCellBytes - sizeof(Index)];
  };
  static_assert(sizeof(Cell) == kCellBytes);
  static constexpr std::size_t kCellBodyBytes = sizeof(Cell::data);
  struct Entry {
    Value value{};
    Index cells = kNone;  // of its body
    Index next = kNone;   // with the same hash, or the next free one
    Index older = kNone;  // in order of renewal
    Index newer = kNone;
  };

  [[nodiscard]] bool has_class(Address source) const {
    const std::uint32_t id = source.fields(rule_.widths).class_id;
    return id < NewestRule::kClassIds && rule_.classes[id];
  }
  [[nodiscard]] std::size_t bucket(Address source, StreamKind kind) const;
  [[nodiscard]] Index find_entry(Address source, StreamKind kind) const;
  Index add_entry(Address source, StreamKind kind);
  void evict_oldest();
  void link_newest(Index index);
  void unlink(Index index);
  void store(Entry& entry, std::span<const std::byte> body);
  void release_cells(Entry& entry);
  [[nodiscard]] std::size_t free_cells() const { return cell_count_ - cells_used_; }
  static std::size_t cells_for(std::size_t size) {
    return (size + kCellBodyBytes - 1) / kCellBodyBytes;
  }

  NewestRule rule_;
  HashSeed seed_;
  std::size_t cell_count_;
  std::unique_ptr<Cell[]> cells_;
  std::size_t cells_used_ = 0;
  std::size_t cells_touched_ = 0;  // cells from here on were never used
  Index free_cell_ = kNone;        // among the others
  std::vector<Entry> entries_;     // memory for all is reserved
  std::size_t entries_max_;
  Index free_entry_ = kNone;
  std::vector<Index> buckets_;  // a power of two
  Index oldest_ = kNone;
  Index newest_ = kNone;
  Counts counts_;
};

}  // namespace tims::core
