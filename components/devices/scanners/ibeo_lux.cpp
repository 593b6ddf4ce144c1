#include "components/devices/scanners/ibeo_lux.h"

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string_view>
#include <utility>

namespace rack::device {
namespace {

constexpr std::string_view kIbeoLuxMagic = "\xAF\xFE\xC0\xC2";
constexpr i32 kIbeoLuxRangeMax = 200'000;
constexpr std::size_t kIbeoLuxPointsMax = decltype(LadarData::points)::kMax;
constexpr std::size_t kObjectsMax = decltype(ObjRecogData::objects)::kMax;
constexpr int kLayers = 4;
constexpr i32 kOfCentimetre = 10;
constexpr std::uint16_t kNoContour = 0xFFFF;  // fault of the scanner: no points follow

constexpr unsigned kTransparent = 0x01;
constexpr unsigned kRain = 0x02;
constexpr unsigned kGround = 0x04;
constexpr unsigned kDirt = 0x08;

i32 type_of(unsigned flags) {
  if ((flags & kTransparent) != 0) return ladar_point::kTransparent;
  if ((flags & kRain) != 0) return ladar_point::kRain;
  if ((flags & kGround) != 0) return ladar_point::kInvalid;
  if ((flags & kDirt) != 0) return ladar_point::kDirt;
  return ladar_point::kUnknown;
}

i32 signed_at(std::span<const std::byte> bytes, std::size_t at) {
  return little_endian<std::int16_t>(bytes, at);
}
i32 unsigned_at(std::span<const std::byte> bytes, std::size_t at) {
  return little_endian<std::uint16_t>(bytes, at);
}

// Converts cm with y to the left to mm with y to the right.
Point2d point_at(std::span<const std::byte> bytes, std::size_t at) {
  return {.x = kOfCentimetre * signed_at(bytes, at),
          .y = -kOfCentimetre * signed_at(bytes, at + 2)};
}

Velocity3d speed_at(std::span<const std::byte> object, bool absolute) {
  constexpr std::size_t kAbsolute = 38;
  constexpr std::size_t kRelative = 46;
  constexpr i32 kUnknown = -0x8000;
  const std::size_t at = absolute ? kAbsolute : kRelative;
  const i32 x = signed_at(object, at);
  const i32 y = signed_at(object, at + 2);
  Velocity3d speed;
  if (x != kUnknown) speed.x = kOfCentimetre * x;
  if (y != kUnknown) speed.y = -kOfCentimetre * y;
  return speed;
}

ObjRecogObject box_of(std::span<const std::byte> object, bool absolute) {
  constexpr double kAngle = std::numbers::pi / 180 / 32;
  ObjRecogObject box;
  box.objectId = unsigned_at(object, 0);
  const i32 kind = unsigned_at(object, 50);
  box.type = kind <= object_type::kTruck ? kind : object_type::kUnclassified;
  const Point2d centre = point_at(object, 28);
  box.pos.x = centre.x;
  box.pos.y = centre.y;
  box.pos.rho = static_cast<f32>(-signed_at(object, 36) * kAngle);
  box.varPos.x = kOfCentimetre * std::abs(signed_at(object, 12));
  box.varPos.y = kOfCentimetre * std::abs(signed_at(object, 14));
  box.vel = speed_at(object, absolute);
  box.varVel.x = kOfCentimetre * unsigned_at(object, 42);
  box.varVel.y = kOfCentimetre * unsigned_at(object, 44);
  box.dim.x = kOfCentimetre * unsigned_at(object, 32);
  box.dim.y = kOfCentimetre * unsigned_at(object, 34);
  return box;
}

// A line segment of a contour: centre, length and direction.
ObjRecogObject piece_of(const ObjRecogObject& box, const Point2d& from, const Point2d& to) {
  const double dx = static_cast<double>(to.x.raw() - from.x.raw());
  const double dy = static_cast<double>(to.y.raw() - from.y.raw());
  ObjRecogObject piece;
  piece.objectId = box.objectId;
  piece.type = box.type;
  piece.pos.x = (from.x.raw() + to.x.raw()) / 2;
  piece.pos.y = (from.y.raw() + to.y.raw()) / 2;
  piece.pos.rho = static_cast<f32>(std::atan2(dy, dx));
  piece.vel = box.vel;
  piece.dim.x = static_cast<i32>(std::hypot(dx, dy));
  return piece;
}

void add_contour(std::span<const std::byte> points, const ObjRecogObject& box,
                 ObjRecogData& contours) {
  constexpr std::size_t kSize = 4;
  for (std::size_t at = kSize; at + kSize <= points.size(); at += kSize) {
    if (contours.objects.size() == kObjectsMax) return;
    contours.objects.push_back(piece_of(box, point_at(points, at - kSize), point_at(points, at)));
  }
}

}  // namespace

void LuxMessages::clear() {
  buffer_.clear();
  used_ = 0;
}

bool LuxMessages::next(LuxMessage& message) {
  buffer_.consume(std::exchange(used_, 0));
  for (;;) {
    const auto bytes = buffer_.bytes();
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t at = text.find(kIbeoLuxMagic);
    if (at != 0) {
      // The end of the buffer may contain the beginning of the magic bytes.
      const std::size_t keep = kIbeoLuxMagic.size() - 1;
      const std::size_t skip =
          at != std::string_view::npos ? at : bytes.size() - std::min(bytes.size(), keep);
      lost_ += skip;
      buffer_.consume(skip);
      if (at == std::string_view::npos) return false;
      continue;
    }
    if (bytes.size() < lux::kHead) return false;
    const std::size_t size = big_endian<std::uint32_t>(bytes, 8);
    if (size > kBodyMax) {
      ++lost_;
      buffer_.consume(1);
      continue;
    }
    if (bytes.size() < lux::kHead + size) return false;
    message = {.kind = big_endian<std::uint16_t>(bytes, 14),
               .made = lux_microseconds(big_endian<std::uint64_t>(bytes, 16)),
               .body = bytes.subspan(lux::kHead, size),
               .began = buffer_.time_of(0)};
    used_ = lux::kHead + size;
    return true;
  }
}

bool decode_lux_scan(std::span<const std::byte> body, bool only_nearest, LadarData& scan,
                     LuxScan& times) {
  if (body.size() < lux::kScanHead) return false;
  const std::size_t points = little_endian<std::uint16_t>(body, 28);
  const i32 ticks = unsigned_at(body, 22);
  if (ticks == 0 || body.size() < lux::kScanHead + points * lux::kPoint) return false;
  const double tick = -2 * std::numbers::pi / ticks;  // clockwise
  times = {.begin = lux_microseconds(little_endian<std::uint64_t>(body, 6)),
           .end = lux_microseconds(little_endian<std::uint64_t>(body, 14))};
  scan.startAngle = static_cast<f32>(tick * signed_at(body, 24));
  scan.endAngle = static_cast<f32>(tick * signed_at(body, 26));
  scan.maxRange = kIbeoLuxRangeMax;
  scan.points.clear();
  for (int layer = 0; layer < kLayers; ++layer) {
    const std::size_t begin = scan.points.size();
    for (std::size_t i = 0; i < points; ++i) {
      const auto point = body.subspan(lux::kScanHead + i * lux::kPoint, lux::kPoint);
      if (std::to_integer<int>(point[0] & std::byte{0x0F}) != layer) continue;
      LadarPoint next{.angle = static_cast<f32>(tick * signed_at(point, 2)),
                      .distance = kOfCentimetre * unsigned_at(point, 4),
                      .type = type_of(std::to_integer<unsigned>(point[1])),
                      .intensity = unsigned_at(point, 6)};  // echo width, cm
      LadarPoint* const last = scan.points.size() > begin ? &scan.points.back() : nullptr;
      if (only_nearest && last != nullptr && last->angle == next.angle) {
        const bool is_object = next.type == ladar_point::kUnknown;
        const bool is_nearer =
            next.distance < last->distance || last->type != ladar_point::kUnknown;
        if (is_object && is_nearer) *last = next;
      } else if (scan.points.size() < kIbeoLuxPointsMax) {
        scan.points.push_back(next);
      }
    }
  }
  return true;
}

bool decode_lux_objects(std::span<const std::byte> body, bool absolute, ObjRecogData& boxes,
                        ObjRecogData& contours, std::int64_t& began) {
  boxes.objects.clear();
  contours.objects.clear();
  if (body.size() < lux::kObjectsHead) return false;
  began = lux_microseconds(little_endian<std::uint64_t>(body));
  const std::size_t objects = little_endian<std::uint16_t>(body, 8);
  body = body.subspan(lux::kObjectsHead);
  for (std::size_t i = 0; i < objects; ++i) {
    if (body.size() < lux::kObject) return false;
    const auto object = body.first(lux::kObject);
    body = body.subspan(lux::kObject);
    const std::uint16_t point_count = little_endian<std::uint16_t>(object, 56);
    const std::size_t contour = point_count == kNoContour ? 0 : std::size_t{4} * point_count;
    if (body.size() < contour) return false;
    const ObjRecogObject box = box_of(object, absolute);
    if (boxes.objects.size() < kObjectsMax) boxes.objects.push_back(box);
    add_contour(body.first(contour), box, contours);
    body = body.subspan(contour);
  }
  return true;
}

IbeoLux::IbeoLux(const IbeoLuxSettings& settings) : settings_(settings) {
  reserve_all(scan_);
  reserve_all(boxes_);
  reserve_all(contours_);
}

void IbeoLux::start(Time, Output&) {
  clear_failure();
  messages_.clear();
  clock_.reset();
  is_ready_ = has_scan_ = has_objects_ = false;
}

void IbeoLux::on_arrival(const Arrival& arrival, Output&) {
  messages_.add(arrival);
  LuxMessage message;
  while (messages_.next(message)) {
    if (message.kind == lux::kScan) take_scan(message);
    if (message.kind == lux::kObjects) take_list(message);
  }
}

// Converts a time of the scanner to host time. The clock of the scanner may be set at any time, and
// its times may be invalid.
Time IbeoLux::host_time(const LuxMessage& message, std::int64_t when) {
  constexpr std::int64_t kOldest = 1'000'000;
  const Time made = clock_.to_host(static_cast<std::uint64_t>(message.made), message.began);
  const std::int64_t age = message.made - when;
  return age < 0 || age > kOldest ? made : made - std::chrono::microseconds(age);
}

void IbeoLux::take_scan(const LuxMessage& message) {
  LuxScan times;
  if (!decode_lux_scan(message.body, settings_.only_nearest, scan_, times)) return;
  constexpr std::int64_t kLongest = 1'000'000;
  constexpr std::int64_t kMillisecond = 1000;
  const std::int64_t took = times.end - times.begin;
  const bool is_sane = took >= 0 && took < kLongest;
  scan_.duration = is_sane ? static_cast<u32>((took + kMillisecond / 2) / kMillisecond) : 0;
  recorded_ = host_time(message, is_sane ? times.begin + took / 2 : times.end);
  has_scan_ = is_ready_ = true;
}

void IbeoLux::take_list(const LuxMessage& message) {
  std::int64_t began = 0;
  if (!decode_lux_objects(message.body, settings_.absolute_speeds, boxes_, contours_, began))
    return;
  objects_recorded_ = host_time(message, began);
  has_objects_ = true;
}

bool IbeoLux::take(LadarData& scan, Time& recorded) {
  if (!std::exchange(has_scan_, false)) return false;
  std::swap(scan, scan_);
  recorded = recorded_;
  return true;
}

bool IbeoLux::take_objects(ObjRecogData& boxes, ObjRecogData& contours, Time& recorded) {
  if (!std::exchange(has_objects_, false)) return false;
  std::swap(boxes, boxes_);
  std::swap(contours, contours_);
  recorded = objects_recorded_;
  return true;
}

}  // namespace rack::device
