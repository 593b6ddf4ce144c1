#include "components/devices/scanners/cola_scan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rack::device {
namespace {

constexpr std::size_t kContent = 5;
constexpr std::size_t kEventType = 4;
constexpr std::size_t kChannelsMax = 16;
constexpr std::size_t kEncodersMax = 8;
constexpr std::size_t kColaScanPointsMax = 2160;  // capacity of LadarData
constexpr unsigned kLeastDistance = 16;           // lower values are codes
constexpr double kUnitsOfDegree = 10000;
constexpr double kRadian = std::numbers::pi / 180;

std::array<std::uint8_t, 2> take_pair(ColaReader& reader) {
  const auto first = reader.take<std::uint8_t>();
  return {first, reader.take<std::uint8_t>()};
}

void take_head(ColaReader& reader, ColaScan& scan) {
  scan.version = reader.take<std::uint16_t>();
  scan.device_number = reader.take<std::uint16_t>();
  scan.serial_number = reader.take<std::uint32_t>();
  scan.device_status = take_pair(reader);
  scan.telegram_counter = reader.take<std::uint16_t>();
  scan.scan_counter = reader.take<std::uint16_t>();
  scan.started = reader.take<std::uint32_t>();
  scan.transmitted = reader.take<std::uint32_t>();
  scan.inputs = take_pair(reader);
  scan.outputs = take_pair(reader);
  scan.layer_angle = reader.take<std::int16_t>();
  scan.scan_frequency = reader.take<std::uint32_t>();
  scan.measuring_frequency = reader.take<std::uint32_t>();
}

bool take_encoders(ColaReader& reader, ColaScan& scan) {
  scan.encoders.clear();
  const std::size_t count = reader.take<std::uint16_t>();
  if (count > kEncodersMax) return false;
  for (std::size_t i = 0; i < count; ++i) {
    const auto position = reader.take<std::uint32_t>();
    scan.encoders.push_back({.position = position, .speed = reader.take<std::uint16_t>()});
  }
  return reader.good();
}

bool take_channels(ColaReader& reader, bool is_wide, ColaScan& scan) {
  const std::size_t count = reader.take<std::uint16_t>();
  if (count + scan.channel_count > kChannelsMax) return false;
  for (std::size_t i = 0; i < count && reader.good(); ++i) {
    if (scan.channel_count == scan.channels.size()) scan.channels.emplace_back();
    ColaChannel& channel = scan.channels[scan.channel_count++];
    const std::string_view content = reader.take_text(kContent);
    channel.content = {};
    std::copy_n(content.begin(), std::min(content.size(), kContent), channel.content.begin());
    channel.scale = reader.take_float();
    channel.offset = reader.take_float();
    channel.start_angle = reader.take<std::int32_t>();
    channel.step = reader.take<std::uint16_t>();
    channel.is_wide = is_wide;
    const std::size_t values = reader.take<std::uint16_t>();
    reader.take_values(values, is_wide, channel.values);
  }
  return reader.good();
}

void take_position(ColaReader& reader, ColaScan& scan) {
  scan.position.reset();
  if (reader.take<std::uint16_t>() == 0) return;
  ColaPosition& position = scan.position.emplace();
  for (float& value : position.place) value = reader.take_float();
  for (float& value : position.rotation) value = reader.take_float();
  position.rotation_type = reader.take<std::uint8_t>();
  position.transmits_name = reader.take<std::uint8_t>();
}

void take_name(ColaReader& reader, std::string& name) {
  name.clear();
  if (reader.take<std::uint16_t>() != 0) name = reader.take_string();
}

void take_time(ColaReader& reader, ColaScan& scan) {
  scan.time.reset();
  if (reader.take<std::uint16_t>() == 0) return;
  ColaTime& time = scan.time.emplace();
  time.year = reader.take<std::uint16_t>();
  time.month = reader.take<std::uint8_t>();
  time.day = reader.take<std::uint8_t>();
  time.hour = reader.take<std::uint8_t>();
  time.minute = reader.take<std::uint8_t>();
  time.second = reader.take<std::uint8_t>();
  time.microsecond = reader.take<std::uint32_t>();
}

void take_event(ColaReader& reader, ColaScan& scan) {
  scan.event.reset();
  if (reader.take<std::uint16_t>() == 0) return;
  ColaEvent& event = scan.event.emplace();
  const std::string_view type = reader.take_text(kEventType);
  std::copy_n(type.begin(), std::min(type.size(), kEventType), event.type.begin());
  event.encoder = reader.take<std::uint32_t>();
  event.time = reader.take<std::uint32_t>();
  event.angle = reader.take<std::int32_t>();
}

// Steps are rounded to 1/10000 degree, but are integer fractions of a degree: 1667 is a sixth.
double step_of(const ColaChannel& channel) {
  const double parts = std::round(kUnitsOfDegree / std::max<int>(1, channel.step));
  const double exact = kUnitsOfDegree / std::max(1.0, parts);
  return (std::abs(exact - channel.step) < 1 ? exact : channel.step) / kUnitsOfDegree;
}

// Whether values need no scaling.
bool is_plain(const ColaChannel& channel) { return channel.scale == 1 && channel.offset == 0; }

std::int32_t scaled(const ColaChannel& channel, unsigned value) {
  const double number = static_cast<double>(value) * channel.scale + channel.offset;
  return static_cast<std::int32_t>(std::clamp(std::isnan(number) ? 0.0 : number, -2e9, 2e9));
}

}  // namespace

const ColaChannel* ColaScan::channel(std::string_view content) const {
  for (std::size_t i = 0; i < channel_count; ++i)
    if (channels[i].name() == content) return &channels[i];
  return nullptr;
}

Duration ColaScan::turn() const {
  constexpr std::int64_t kHundredSeconds = 100'000'000'000;
  return Duration(scan_frequency == 0 ? 0 : kHundredSeconds / scan_frequency);
}

bool decode_cola_scan(const ColaTelegram& telegram, ColaScan& scan) {
  ColaReader reader(telegram);
  if (reader.name() != "LMDscandata" || (reader.kind() != "sSN" && reader.kind() != "sRA"))
    return false;
  scan.channel_count = 0;
  take_head(reader, scan);
  if (!take_encoders(reader, scan)) return false;
  if (!take_channels(reader, true, scan) || !take_channels(reader, false, scan)) return false;
  take_position(reader, scan);
  take_name(reader, scan.name);
  take_name(reader, scan.comment);
  take_time(reader, scan);
  // Telegrams of some older scanners end here.
  if (!reader.at_end())
    take_event(reader, scan);
  else
    scan.event.reset();
  return reader.good();
}

namespace {

void put_channels(ColaWriter& writer, const ColaScan& scan, bool is_wide) {
  const auto used = std::span(scan.channels).first(scan.channel_count);
  const auto is_one = [&](const ColaChannel& channel) { return channel.is_wide == is_wide; };
  writer.put(static_cast<std::uint16_t>(std::ranges::count_if(used, is_one)));
  for (const ColaChannel& channel : used) {
    if (!is_one(channel)) continue;
    writer.put_text(channel.name()).put_float(channel.scale).put_float(channel.offset);
    writer.put(channel.start_angle).put(channel.step);
    writer.put(static_cast<std::uint16_t>(channel.values.size()));
    for (const std::uint16_t value : channel.values) {
      if (is_wide)
        writer.put(value);
      else
        writer.put(static_cast<std::uint8_t>(value));
    }
  }
}

void put_name(ColaWriter& writer, const std::string& name) {
  writer.put(std::uint16_t{!name.empty()});
  if (!name.empty()) writer.put_string(name);
}

void put_position(ColaWriter& writer, const ColaScan& scan) {
  writer.put(std::uint16_t{scan.position.has_value()});
  if (!scan.position) return;
  for (const float value : scan.position->place) writer.put_float(value);
  for (const float value : scan.position->rotation) writer.put_float(value);
  writer.put(scan.position->rotation_type).put(scan.position->transmits_name);
}

void put_time(ColaWriter& writer, const ColaScan& scan) {
  writer.put(std::uint16_t{scan.time.has_value()});
  if (!scan.time) return;
  const ColaTime& time = *scan.time;
  writer.put(time.year).put(time.month).put(time.day).put(time.hour).put(time.minute);
  writer.put(time.second).put(time.microsecond);
}

void put_event(ColaWriter& writer, const ColaScan& scan) {
  writer.put(std::uint16_t{scan.event.has_value()});
  if (!scan.event) return;
  const ColaEvent& event = *scan.event;
  writer.put_text({event.type.data(), event.type.size()});
  writer.put(event.encoder).put(event.time).put(event.angle);
}

}  // namespace

void append_cola_scan(std::vector<std::byte>& body, ColaDialect dialect, const ColaScan& scan,
                      std::string_view command) {
  ColaWriter writer(dialect, body, command);
  writer.put(scan.version).put(scan.device_number).put(scan.serial_number);
  writer.put(scan.device_status[0]).put(scan.device_status[1]);
  writer.put(scan.telegram_counter).put(scan.scan_counter);
  writer.put(scan.started).put(scan.transmitted);
  writer.put(scan.inputs[0]).put(scan.inputs[1]).put(scan.outputs[0]).put(scan.outputs[1]);
  writer.put(scan.layer_angle).put(scan.scan_frequency).put(scan.measuring_frequency);
  writer.put(static_cast<std::uint16_t>(scan.encoders.size()));
  for (const ColaEncoder& encoder : scan.encoders) writer.put(encoder.position).put(encoder.speed);
  put_channels(writer, scan, true);
  put_channels(writer, scan, false);
  put_position(writer, scan);
  put_name(writer, scan.name);
  put_name(writer, scan.comment);
  put_time(writer, scan);
  put_event(writer, scan);
}

bool scan_of_cola(const ColaScan& from, const ColaView& view, LadarData& scan) {
  const ColaChannel* const distances = from.channel("DIST1");
  if (distances == nullptr || distances->values.empty()) return false;
  const std::size_t values = distances->values.size();
  const ColaChannel* remission = from.channel("RSSI1");
  if (remission != nullptr && remission->values.size() != values) remission = nullptr;

  const std::size_t every = (values + kColaScanPointsMax - 1) / kColaScanPointsMax;
  const std::size_t count = (values + every - 1) / every;
  const double step = step_of(*distances) * static_cast<double>(every) * kRadian;
  const ColaFront& front = view.front;
  // Angles of a LadarData increase clockwise.
  const double sign = front.is_clockwise ? 1 : -1;
  const double first = sign * (distances->start_angle / kUnitsOfDegree - front.degrees) * kRadian;
  const bool plain = is_plain(*distances);
  const bool plain_remission = remission == nullptr || is_plain(*remission);

  scan.points.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned value = distances->values[i * every];
    const unsigned strength = remission == nullptr ? 0 : remission->values[i * every];
    const bool is_measured = value >= kLeastDistance;
    LadarPoint& point = scan.points[front.is_clockwise ? i : count - 1 - i];
    point.angle = static_cast<float>(first + sign * static_cast<double>(i) * step);
    point.intensity = plain_remission ? static_cast<i32>(strength) : scaled(*remission, strength);
    point.distance = !is_measured ? 0 : plain ? static_cast<i32>(value) : scaled(*distances, value);
    const bool is_reflector =
        view.reflector_remission > 0 && point.intensity >= view.reflector_remission;
    point.type = !is_measured   ? ladar_point::kInvalid
                 : is_reflector ? ladar_point::kReflector
                                : ladar_point::kUnknown;
  }
  scan.startAngle = scan.points.front().angle;
  scan.endAngle = scan.points.back().angle;
  scan.maxRange = view.max_range;
  const double part = static_cast<double>(count - 1) * step / (2 * std::numbers::pi);
  const double turn = std::chrono::duration<double, std::milli>(from.turn()).count();
  scan.duration = static_cast<u32>(std::lround(std::min(1.0, part) * turn));
  return true;
}

}  // namespace rack::device
