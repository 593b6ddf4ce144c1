#include "rack/proxies/scan3d_compression.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <optional>
#include <string>

namespace rack {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kPointBytes = 20;
constexpr std::size_t kHead = 14;  // header size of each stage
constexpr u32 kMagic1 = 0x4D31;
constexpr u32 kMagic2 = 0x4D32;
constexpr u32 kMagic3 = 0x4D43;
constexpr u32 kPlain = 0;      // of all stages
constexpr u32 kDeltaRuns = 5;  // stage 1
constexpr u32 kHuffman = 0x31;
constexpr u32 kMethod = 0xFF;
constexpr u32 kWithoutInvalid = 0xFF000000;

constexpr u32 kFar = 255;   // instead of a difference: the value itself follows
constexpr u32 kHere = 128;  // difference 0
constexpr u32 kRunMax = 255;
constexpr std::size_t kFieldsHead = 22;  // minima and widths

tims::Error malformed(std::string text) {
  return {tims::Errc::kMalformed, "compressed scan: " + std::move(text)};
}

u32 bytes_for(u32 largest) { return (static_cast<u32>(std::bit_width(largest)) + 7) / 8; }

// --- big-endian numbers

class Writer {
 public:
  explicit Writer(std::span<std::byte> to) : to_(to) {}

  void put(u32 value, u32 bytes) {
    if (size_ + bytes > to_.size()) {
      is_full_ = true;
      return;
    }
    for (u32 i = bytes; i > 0; --i) to_[size_++] = static_cast<std::byte>(value >> 8 * (i - 1));
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool is_full() const { return is_full_; }

 private:
  std::span<std::byte> to_;
  std::size_t size_ = 0;
  bool is_full_ = false;
};

class Reader {
 public:
  explicit Reader(Bytes from) : from_(from) {}

  u32 get(u32 bytes) {
    if (bytes > from_.size() - at_) {
      is_short_ = true;
      at_ = from_.size();
      return 0;
    }
    u32 value = 0;
    for (u32 i = 0; i < bytes; ++i) value = value << 8 | std::to_integer<u32>(from_[at_++]);
    return value;
  }
  [[nodiscard]] bool is_short() const { return is_short_; }

 private:
  Bytes from_;
  std::size_t at_ = 0;
  bool is_short_ = false;
};

// --- stage 1: the fields of the points as unsigned numbers, and back

struct Range {
  i32 min = std::numeric_limits<i32>::max();
  i32 max = std::numeric_limits<i32>::min();

  void add(i32 value) {
    min = std::min(min, value);
    max = std::max(max, value);
  }
  // Bytes needed for a value after the minimum is subtracted.
  [[nodiscard]] u32 width() const {
    return bytes_for(static_cast<u32>(max) - static_cast<u32>(min));
  }
  // Bytes needed for the values themselves, at most `most`. With width 0 the original decoder
  // returns 0, whatever the minimum is.
  [[nodiscard]] u32 raw_width(u32 most) const {
    return min < 0 ? most : bytes_for(static_cast<u32>(max));
  }
};

struct Ranges {
  Range x, y, z, type, segment, intensity;

  explicit Ranges(std::span<const ScanPoint> points) {
    for (const ScanPoint& point : points) {
      x.add(point.x);
      y.add(point.y);
      z.add(point.z);
      type.add(point.type);
      segment.add(point.segment);
      intensity.add(point.intensity);
    }
  }
  [[nodiscard]] u32 intensity_width() const {
    const bool is_zero = intensity.min == 0 && intensity.max == 0;
    return is_zero ? 0 : std::max(1U, intensity.width());
  }
};

template <typename Get>
void put_differences(std::span<const ScanPoint> points, const Range& range, Get get, Writer& out) {
  const u32 width = range.width();
  u32 last = 0;
  bool is_first = true;
  for (const ScanPoint& point : points) {
    const auto value = static_cast<u32>(get(point));
    const u32 difference = value - last + kHere;
    if (!is_first) out.put(std::min(difference, kFar), 1);
    if (is_first || difference >= kFar) out.put(value - static_cast<u32>(range.min), width);
    is_first = false;
    last = value;
  }
}

template <typename Get>
void put_runs(std::span<const ScanPoint> points, u32 width, Get get, Writer& out) {
  if (width == 0) return;
  for (std::size_t i = 0; i < points.size();) {
    const auto value = get(points[i]);
    u32 count = 1;
    while (count < kRunMax && i + count < points.size() && get(points[i + count]) == value) ++count;
    out.put(static_cast<u32>(value), width);
    out.put(count, 1);
    i += count;
  }
}

void put_points(std::span<const ScanPoint> points, Writer& out) {
  const Ranges ranges(points);
  for (const Range* range : {&ranges.x, &ranges.y, &ranges.z, &ranges.type})
    out.put(0U - static_cast<u32>(range->min), 4);
  for (const Range* range : {&ranges.segment, &ranges.intensity})
    out.put(0U - static_cast<u32>(range->min), 2);
  const u32 types = ranges.type.raw_width(4);
  const u32 segments = ranges.segment.raw_width(2);
  const u32 intensities = ranges.intensity_width();
  out.put(ranges.x.width() << 13 | ranges.y.width() << 10 | ranges.z.width() << 7 | types << 4 |
              segments << 2 | intensities,
          2);
  put_differences(
      points, ranges.x, [](const ScanPoint& p) { return p.x.raw(); }, out);
  put_differences(
      points, ranges.y, [](const ScanPoint& p) { return p.y.raw(); }, out);
  put_differences(
      points, ranges.z, [](const ScanPoint& p) { return p.z.raw(); }, out);
  put_runs(
      points, types, [](const ScanPoint& p) { return p.type; }, out);
  put_runs(
      points, segments, [](const ScanPoint& p) { return p.segment; }, out);
  if (intensities == 0) return;
  for (const ScanPoint& point : points)
    out.put(static_cast<u32>(point.intensity - ranges.intensity.min), intensities);
}

struct Field {
  u32 negated_min = 0;
  u32 width = 0;
};

template <typename Set>
void get_differences(std::span<ScanPoint> points, const Field& field, Set set, Reader& in) {
  u32 last = 0;
  bool is_first = true;
  for (ScanPoint& point : points) {
    const u32 difference = is_first ? kFar : in.get(1);
    last = difference == kFar ? in.get(field.width) - field.negated_min : last + difference - kHere;
    set(point, static_cast<i32>(last));
    is_first = false;
  }
}

// False: a run extends beyond the last point.
template <typename Set>
bool get_runs(std::span<ScanPoint> points, const Field& field, Set set, Reader& in) {
  if (field.width == 0) {  // all values are equal
    for (ScanPoint& point : points) set(point, static_cast<i32>(0U - field.negated_min));
    return true;
  }
  for (std::size_t i = 0; i < points.size() && !in.is_short();) {
    const u32 value = in.get(field.width);
    const u32 written = in.get(1);
    const std::size_t count = written == 0 ? 256 : written;  // the original encoder writes 256 as 0
    if (count > points.size() - i) return false;
    for (ScanPoint& point : points.subspan(i, count)) set(point, static_cast<i32>(value));
    i += count;
  }
  return true;
}

tims::Result<void> get_differences_and_runs(Reader& in, std::span<ScanPoint> points) {
  std::array<Field, 6> fields;
  for (std::size_t i = 0; i < fields.size(); ++i) fields[i].negated_min = in.get(i < 4 ? 4 : 2);
  const u32 widths = in.get(2);
  constexpr std::array<u32, 6> kShifts = {13, 10, 7, 4, 2, 0};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    fields[i].width = widths >> kShifts[i] & (i < 4 ? 7U : 3U);
    if (fields[i].width > (i < 4 ? 4U : 2U)) return malformed("a field is too wide");
  }
  get_differences(
      points, fields[0], [](ScanPoint& p, i32 value) { p.x = value; }, in);
  get_differences(
      points, fields[1], [](ScanPoint& p, i32 value) { p.y = value; }, in);
  get_differences(
      points, fields[2], [](ScanPoint& p, i32 value) { p.z = value; }, in);
  const bool fit = get_runs(
                       points, fields[3], [](ScanPoint& p, i32 value) { p.type = value; }, in) &&
                   get_runs(
                       points, fields[4],
                       [](ScanPoint& p, i32 value) { p.segment = static_cast<i16>(value); }, in);
  if (!fit) return malformed("a run of types or segments goes beyond the last point");
  for (ScanPoint& point : points)
    point.intensity = static_cast<i16>(in.get(fields[5].width) - fields[5].negated_min);
  return {};
}

void get_plain(Reader& in, std::span<ScanPoint> points) {
  for (ScanPoint& point : points) {
    point.x = static_cast<i32>(in.get(4));
    point.y = static_cast<i32>(in.get(4));
    point.z = static_cast<i32>(in.get(4));
    point.type = static_cast<i32>(in.get(4));
    point.segment = static_cast<i16>(in.get(2));
    point.intensity = static_cast<i16>(in.get(2));
  }
}

// --- stage 3: Huffman

constexpr std::size_t kEnd = 256;  // end symbol, after all byte values

class Tree {
 public:
  using Counts = std::array<u32, 257>;

  explicit Tree(const Counts& counts) {
    std::ranges::copy(counts, counts_.begin());
    for (next_ = kEnd + 1;; ++next_) {
      const auto [rarest, second] = two_rarest();
      if (second == kNone) break;
      counts_[next_] = counts_[rarest] + counts_[second];
      counts_[rarest] = counts_[second] = 0;
      children_[next_] = {static_cast<u16>(rarest), static_cast<u16>(second)};
    }
  }

  [[nodiscard]] std::size_t root() const { return next_ - 1; }
  [[nodiscard]] static bool is_leaf(std::size_t node) { return node <= kEnd; }
  [[nodiscard]] std::size_t child(std::size_t node, unsigned bit) const {
    return children_[node][bit];
  }

 private:
  static constexpr std::size_t kNodes = 513;
  static constexpr std::size_t kNone = kNodes;

  // Of equal counts, the first nodes are taken.
  [[nodiscard]] std::array<std::size_t, 2> two_rarest() const {
    std::size_t rarest = kNone;
    std::size_t second = kNone;
    const auto count = [&](std::size_t node) {
      return node == kNone ? std::numeric_limits<u32>::max() : counts_[node];
    };
    for (std::size_t i = 0; i < next_; ++i) {
      if (counts_[i] == 0) continue;
      if (counts_[i] < count(rarest)) {
        second = rarest;
        rarest = i;
      } else if (counts_[i] < count(second)) {
        second = i;
      }
    }
    return {rarest, second};
  }

  std::array<u32, kNodes> counts_{};
  std::array<std::array<u16, 2>, kNodes> children_{};
  std::size_t next_ = 0;
};

struct Code {
  u32 bits = 0;
  u32 length = 0;
};
using Codes = std::array<Code, 257>;

// Counts are at most 255, so no code has more than 24 bits.
void find_codes(const Tree& tree, std::size_t node, Code code, Codes& codes) {
  if (Tree::is_leaf(node)) {
    codes[node] = code;
    return;
  }
  for (unsigned bit = 0; bit < 2; ++bit)
    find_codes(tree, tree.child(node, bit), {code.bits << 1 | bit, code.length + 1}, codes);
}

Tree::Counts counts_of(Bytes bytes) {
  Tree::Counts counts{};
  for (const std::byte byte : bytes) ++counts[std::to_integer<std::size_t>(byte)];
  const u32 scale = *std::ranges::max_element(counts) / 255 + 1;
  for (u32& count : counts) count = count == 0 ? 0 : std::max(1U, count / scale);
  counts[kEnd] = 1;
  return counts;
}

void put_huffman(Bytes bytes, Writer& out) {
  const Tree::Counts counts = counts_of(bytes);
  for (std::size_t i = 0; i < kEnd; ++i) out.put(counts[i], 1);
  const Tree tree(counts);
  Codes codes{};
  find_codes(tree, tree.root(), {}, codes);
  std::uint64_t kept = 0;
  u32 count = 0;
  const auto put = [&](const Code& code) {
    kept = kept << code.length | code.bits;
    for (count += code.length; count >= 8; count -= 8)
      out.put(static_cast<u32>(kept >> (count - 8)) & 0xFF, 1);
  };
  for (const std::byte byte : bytes) put(codes[std::to_integer<std::size_t>(byte)]);
  put(codes[kEnd]);
  if (count > 0) out.put(static_cast<u32>(kept << (8 - count)) & 0xFF, 1);
}

// Table for the next bits: either a symbol and the length of its code, or an inner node.
constexpr u32 kAtOnce = 11;
struct Step {
  u16 node = 0;
  u8 bits = 0;
};

std::array<Step, 1U << kAtOnce> steps_of(const Tree& tree) {
  std::array<Step, 1U << kAtOnce> steps;
  for (u32 ahead = 0; ahead < steps.size(); ++ahead) {
    std::size_t node = tree.root();
    u32 used = 0;
    while (used < kAtOnce && !Tree::is_leaf(node))
      node = tree.child(node, ahead >> (kAtOnce - ++used) & 1);
    steps[ahead] = {static_cast<u16>(node), static_cast<u8>(used)};
  }
  return steps;
}

// kMalformed: there is no end symbol, or `to` is too small.
tims::Result<void> get_huffman(Bytes from, std::span<std::byte> to) {
  if (from.size() < kEnd) return malformed("it ends within the Huffman counts");
  Tree::Counts counts{};
  for (std::size_t i = 0; i < kEnd; ++i) counts[i] = std::to_integer<u32>(from[i]);
  counts[kEnd] = 1;
  const Tree tree(counts);
  if (Tree::is_leaf(tree.root())) return malformed("its Huffman counts are all 0");
  const auto steps = steps_of(tree);
  const Bytes data = from.subspan(kEnd);
  std::uint64_t kept = 0;
  u32 count = 0;  // number of bits in kept
  std::size_t at = 0;
  const std::size_t bits_all = 8 * data.size();
  std::size_t bits_used = 0;
  for (std::size_t size = 0;;) {
    while (count <= 48) {
      kept = kept << 8 | (at < data.size() ? std::to_integer<std::uint64_t>(data[at]) : 0U);
      ++at;
      count += 8;
    }
    const Step step = steps[kept >> (count - kAtOnce) & (steps.size() - 1)];
    std::size_t node = step.node;
    u32 used = step.bits;
    while (!Tree::is_leaf(node)) node = tree.child(node, kept >> (count - ++used) & 1);
    count -= used;
    bits_used += used;
    if (bits_used > bits_all) return malformed("it ends within the Huffman code");
    if (node == kEnd) {
      if (size != to.size())
        return malformed("the Huffman code has fewer bytes than its header states");
      return {};
    }
    if (size == to.size())
      return malformed("the Huffman code has more bytes than its header states");
    to[size++] = static_cast<std::byte>(node);
  }
}

// --- the three nested stages

struct Head {
  u32 flags = 0;
  u32 before = 0;  // bytes before this stage
  u32 after = 0;   // bytes after it, including this header
};

void put_head(u32 magic, const Head& head, std::span<std::byte> to) {
  Writer out(to.first(kHead));
  out.put(magic, 2);
  out.put(head.flags, 4);
  out.put(head.before, 4);
  out.put(head.after, 4);
}

bool begins_with(Bytes bytes, u32 magic) {
  return bytes.size() >= 2 && Reader(bytes).get(2) == magic;
}

tims::Result<Head> get_head(Bytes bytes, u32 magic, const char* stage) {
  if (bytes.size() < kHead || !begins_with(bytes, magic))
    return malformed(std::string("the header of stage ") + stage + " is missing");
  Reader in(bytes.subspan(2, kHead - 2));
  const Head head{.flags = in.get(4), .before = in.get(4), .after = in.get(4)};
  if (head.after < kHead || head.after > bytes.size())
    return malformed(std::string("the header of stage ") + stage + " states " +
                     std::to_string(head.after) + " bytes, but there are " +
                     std::to_string(bytes.size()));
  return head;
}

tims::Error unknown(const char* stage, u32 method) {
  return malformed(std::string("method ") + std::to_string(method) + " of stage " + stage +
                   " is not supported");
}

// The output of stage 2; stored in `to` if it had to be decoded.
tims::Result<Bytes> within_stage3(Bytes bytes, std::size_t bytes_max, std::vector<std::byte>& to) {
  const auto head = get_head(bytes, kMagic3, "3");
  if (!head) return head.error();
  const Bytes data = bytes.subspan(kHead, head->after - kHead);
  if (head->flags == kPlain) return data;
  if (head->flags != kHuffman) return unknown("3", head->flags);
  if (head->before > bytes_max) return malformed("it has more bytes than its points need");
  if (to.size() < head->before) to.resize(head->before);
  const auto room = std::span(to).first(head->before);
  if (auto read = get_huffman(data, room); !read) return read.error();
  return Bytes(room);
}

tims::Result<void> get_points(Bytes stage1, std::span<ScanPoint> points) {
  const auto head = get_head(stage1, kMagic1, "1");
  if (!head) return head.error();
  if ((head->flags & kWithoutInvalid) != 0)
    return malformed("invalid points were left out, which is not supported");
  if (head->before != points.size() * kPointBytes)
    return malformed("it has " + std::to_string(head->before / kPointBytes) +
                     " points, but the scan header states " + std::to_string(points.size()));
  Reader in(stage1.subspan(kHead, head->after - kHead));
  const u32 method = head->flags & kMethod;
  if (method == kDeltaRuns) {
    if (auto read = get_differences_and_runs(in, points); !read) return read;
  } else if (method == kPlain) {
    get_plain(in, points);
  } else {
    return unknown("1", method);
  }
  if (in.is_short()) return malformed("it ends within the points");
  return {};
}

}  // namespace

bool Scan3dCompression::compress(Scan3dData& scan) {
  const std::size_t plain = scan.points.size() * kPointBytes;
  if (scan.compressed != 0 || plain == 0 || plain > kScan3dPointsMax * kPointBytes) return false;
  // A decoder has memory only for the size of the points and the headers.
  if (stages_.size() < plain + 2 * kHead) stages_.resize(plain + 2 * kHead);
  const auto stages = std::span(stages_).first(plain + 2 * kHead);
  Writer fields(stages.subspan(2 * kHead));
  put_points(scan.points, fields);
  if (fields.is_full()) return false;
  const auto first = static_cast<u32>(kHead + fields.size());
  put_head(kMagic1, {kDeltaRuns, static_cast<u32>(plain), first}, stages.subspan(kHead));
  const auto second = static_cast<u32>(kHead + first);
  put_head(kMagic2, {kPlain, first, second}, stages);

  if (scan.compressedPoints.size() < plain) scan.compressedPoints.resize(plain);
  Writer code(std::span(scan.compressedPoints).subspan(kHead));
  put_huffman(stages.first(second), code);
  if (code.is_full()) {
    scan.compressedPoints.clear();
    return false;
  }
  const auto third = static_cast<u32>(kHead + code.size());
  put_head(kMagic3, {kHuffman, second, third}, scan.compressedPoints);
  scan.pointNum = static_cast<i32>(scan.points.size());
  scan.compressed = static_cast<i32>(third);
  scan.compressedPoints.resize(third);
  scan.points.clear();
  return true;
}

tims::Result<void> Scan3dCompression::decompress(Scan3dData& scan) {
  if (scan.compressed == 0) return {};
  if (scan.pointNum < 0 || static_cast<std::size_t>(scan.pointNum) > kScan3dPointsMax)
    return malformed("it cannot have " + std::to_string(scan.pointNum) + " points");
  const auto count = static_cast<std::size_t>(scan.pointNum);
  // Large differences need five bytes per coordinate; runs of length one need five and three bytes.
  const std::size_t bytes_max = 25 * count + kFieldsHead + 2 * kHead;
  Bytes bytes(scan.compressedPoints);
  if (!begins_with(bytes, kMagic1)) {
    const auto second = within_stage3(bytes, bytes_max, stages_);
    if (!second) return second.error();
    const auto head = get_head(*second, kMagic2, "2");
    if (!head) return head.error();
    if (head->flags != kPlain) return unknown("2", head->flags & kMethod);
    bytes = second->subspan(kHead, head->after - kHead);
  }
  points_.resize(count);
  if (auto read = get_points(bytes, points_); !read) return read;
  scan.points.assign(points_.begin(), points_.end());
  scan.compressed = 0;
  scan.compressedPoints.clear();
  return {};
}

}  // namespace rack
