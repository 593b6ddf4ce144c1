#include "rack/devices/device_address.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/text.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
namespace base = tims::base;

constexpr std::uint32_t kBaudMin = 50;
constexpr std::uint32_t kBaudMax = 12'000'000;
constexpr double kSpeedMax = 1e6;
constexpr std::int32_t kNumbersOfAKind = 100;
constexpr std::size_t kInterfaceNameMax = 15;  // IFNAMSIZ with its end

struct Scheme {
  std::string_view name;
  TransportKind kind;
  std::string_view example;
  std::array<std::string_view, 5> options{};
};
constexpr std::array<Scheme, 13> kSchemes = {{
    {"serial",
     TransportKind::kSerial,
     "serial:/dev/ttyUSB0?baud=115200",
     {"baud", "parity", "can"}},
    {"tcp", TransportKind::kTcp, "tcp:192.168.0.1:2112"},
    {"udp", TransportKind::kUdp, "udp::2368", {"local"}},
    {"can", TransportKind::kCan, "can:can0"},
    {"usb", TransportKind::kUsb, "usb:15d1:0000"},
    {"v4l", TransportKind::kVideo, "v4l:/dev/video0?size=640x480", {"size", "format", "rate"}},
    {"dcam",
     TransportKind::kDcam,
     "dcam:00b09d0100a1b2c3?size=1280x960&format=UYVY",
     {"size", "format", "rate", "speed"}},
    {"gpio", TransportKind::kGpio, "gpio:/dev/gpiochip0?in=17,27&out=22", {"in", "out", "bias"}},
    {"play",
     TransportKind::kPlayback,
     "play:FILE?speed=1",
     {"speed", "baud", "port", "loop", "interface"}},
    {"pty", TransportKind::kPty, "pty:/tmp/device", {"baud", "can"}},
    {"rtsp", TransportKind::kStream, "rtsp://192.168.0.90/stream1"},
    {"file", TransportKind::kFile, "file:/data/corridor.mp4?loop=1", {"rate", "speed", "loop"}},
    {"gstreamer", TransportKind::kGstreamer, "gstreamer:videotestsrc ! videoconvert"},
}};
constexpr std::array<std::string_view, 3> kStreamsLikeRtsp = {"rtsps", "http", "https"};
constexpr double kRateMax = 1000;                // pictures per second
constexpr std::size_t kPlaceBytesMax = 8 << 10;  // of a URL or a pipeline

const Scheme& scheme_of(TransportKind kind) { return kSchemes.at(static_cast<std::size_t>(kind)); }

Error wrong(std::string_view text, const std::string& why) {
  return {Errc::kInvalidArgument,
          "device " + base::in_quotes(without_passwords(std::string(text))) + ": " + why};
}

const Scheme* find_scheme(std::string_view name) {
  for (const Scheme& scheme : kSchemes)
    if (scheme.name == name) return &scheme;
  if (std::ranges::find(kStreamsLikeRtsp, name) != kStreamsLikeRtsp.end())
    return &scheme_of(TransportKind::kStream);
  return nullptr;
}

// A path without a scheme is a video, a folder of pictures or a camera, as users paste it. Other
// devices need their scheme.
const Scheme* find_scheme_of_path(std::string_view text) {
  if (text.starts_with("/dev/video")) return &scheme_of(TransportKind::kVideo);
  const bool is_path = text.starts_with('/') || text.starts_with("./") || text.starts_with("../");
  if (!is_path || text.starts_with("/dev/")) return nullptr;
  return &scheme_of(TransportKind::kFile);
}

std::string known_schemes() {
  std::string all;
  for (const Scheme& scheme : kSchemes)
    all += (all.empty() ? "" : ", ") + std::string(scheme.name) + ":";
  return all + ", http:, https:, or be the path of a video (/..., ./...)";
}

// Removes the options, for example "?baud=9600&parity=even", from the text.
Result<DeviceAddress> with_options(DeviceAddress address, std::string_view& text) {
  const std::size_t mark = text.rfind('?');
  if (mark == std::string_view::npos) return address;
  const Scheme& scheme = scheme_of(address.kind);
  std::string_view rest = text.substr(mark + 1);
  text = text.substr(0, mark);
  while (!rest.empty()) {
    const std::string_view item = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), item.size() + 1));
    const std::size_t equals = item.find('=');
    const std::string_view name = item.substr(0, equals);
    const bool is_known =
        !name.empty() && std::ranges::find(scheme.options, name) != scheme.options.end();
    if (!is_known || equals == std::string_view::npos)
      return Error(Errc::kInvalidArgument, "unknown option " + base::in_quotes(item) + " of " +
                                               std::string(scheme.name) +
                                               ":, example: " + std::string(scheme.example));
    address.options.insert_or_assign(std::string(name), std::string(item.substr(equals + 1)));
  }
  return address;
}

std::optional<std::string> problem_of_options(const DeviceAddress& address) {
  const auto value = [&](std::string_view name) -> const std::string* {
    const auto found = address.options.find(name);
    return found == address.options.end() ? nullptr : &found->second;
  };
  if (const std::string* baud = value("baud")) {
    const auto number = base::parse_number<std::uint32_t>(*baud);
    if (!number || *number < kBaudMin || *number > kBaudMax)
      return "baud must be a number from 50 to 12000000, not " + base::in_quotes(*baud);
  }
  if (const std::string* can = value("can");
      can != nullptr && !base::parse_number<std::uint32_t>(*can))
    return "can must be the bit rate of the bus behind the adapter, for example 500000, not " +
           base::in_quotes(*can);
  if (const std::string* parity = value("parity");
      parity != nullptr && *parity != "none" && *parity != "even" && *parity != "odd")
    return "parity must be none, even or odd, not " + base::in_quotes(*parity);
  if (const std::string* speed = value("speed");
      speed != nullptr && *speed != "max" && address.kind != TransportKind::kDcam) {
    const auto number = base::parse_number<double>(*speed);
    if (!number || !(*number > 0) || *number > kSpeedMax)
      return "speed must be max or a factor above 0, not " + base::in_quotes(*speed);
  }
  if (const std::string* port = value("port");
      port != nullptr && base::parse_number<std::uint16_t>(*port).value_or(0) == 0)
    return "port must be a number from 1 to 65535, not " + base::in_quotes(*port);
  if (const std::string* local = value("local");
      local != nullptr && !base::parse_number<std::uint16_t>(*local))
    return "local must be a port number, or 0 for any free port, not " + base::in_quotes(*local);
  if (const std::string* rate = value("rate");
      rate != nullptr && address.kind == TransportKind::kFile) {
    const auto number = base::parse_number<double>(*rate);
    if (!number || !(*number > 0) || *number > kRateMax)
      return "rate must be pictures per second, above 0 to 1000, not " + base::in_quotes(*rate);
  }
  if (const std::string* loop = value("loop"); loop != nullptr && *loop != "0" && *loop != "1")
    return "loop must be 0 or 1, not " + base::in_quotes(*loop);
  return std::nullopt;
}

// Takes "host:port" or "[host]:port"; udp addresses may omit the host.
std::optional<std::string> take_host_and_port(DeviceAddress& address, std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return "the port is missing";
  const auto port = base::parse_number<std::uint16_t>(text.substr(colon + 1));
  if (port.value_or(0) == 0) return "the port must be a number from 1 to 65535";
  std::string_view host = text.substr(0, colon);
  const bool in_brackets = host.starts_with('[') && host.ends_with(']');
  if (in_brackets) host = host.substr(1, host.size() - 2);
  if (!in_brackets && host.find(':') != std::string_view::npos)
    return "an IPv6 address must be in brackets";
  if (host.empty() && address.kind == TransportKind::kTcp) return "the host is missing";
  address.place = host;
  address.port = *port;
  return std::nullopt;
}

bool is_hex4(std::string_view text) {
  return text.size() == 4 && base::parse_number<std::uint16_t>(text, 16).has_value();
}

// A number in the list of cameras, or a GUID, or its lower half.
bool is_iidc_camera(std::string_view text) {
  if (text.size() <= 2) return base::parse_number<std::uint8_t>(text).has_value();
  return (text.size() == 8 || text.size() == 16) &&
         base::parse_number<std::uint64_t>(text, 16).has_value();
}

bool is_blank(std::string_view text) {
  return text.find_first_not_of(" \t\r\n") == std::string_view::npos;
}

// Spaces and control characters would reach the header of the request.
std::optional<std::string> problem_of_url(std::string_view url) {
  if (url.size() > kPlaceBytesMax) return "the address has more than 8192 bytes";
  const std::size_t colon = url.find(':');
  std::string_view rest = url.substr(colon + 1);
  if (!rest.starts_with("//")) return "// is missing behind the colon";
  rest = rest.substr(2, rest.find('/', 2) - 2);
  rest = rest.substr(rest.find('@') + 1);
  if (rest.empty() || rest.starts_with(':')) return "the host is missing";
  const auto is_wrong = [](char c) { return c <= ' ' || c == '\x7F'; };
  if (std::ranges::any_of(url, is_wrong)) return "spaces must be written as %20";
  return std::nullopt;
}

std::optional<std::string> problem_of_place(const DeviceAddress& address) {
  const std::string& place = address.place;
  switch (address.kind) {
    case TransportKind::kUsb: {
      const std::string_view ids = std::string_view(place).substr(0, place.find('/'));
      if (ids.size() != 9 || ids[4] != ':' || !is_hex4(ids.substr(0, 4)) || !is_hex4(ids.substr(5)))
        return "vendor and product must have four hex digits each";
      return std::nullopt;
    }
    case TransportKind::kDcam:
      if (!is_iidc_camera(place))
        return "the camera must be 0 to 99 or a GUID of 16 hex digits (or the last 8 of them)";
      return std::nullopt;
    case TransportKind::kStream:
      return problem_of_url(place);
    case TransportKind::kGstreamer:
      if (place.size() > kPlaceBytesMax) return "the pipeline has more than 8192 bytes";
      return is_blank(place) ? std::optional<std::string>("the pipeline is missing") : std::nullopt;
    case TransportKind::kCan:
      if (place.empty() || place.size() > kInterfaceNameMax || place.find('/') != std::string::npos)
        return "the name of an interface must have 1 to 15 characters";
      return std::nullopt;
    default:
      return place.empty() ? std::optional<std::string>("the path is missing") : std::nullopt;
  }
}

}  // namespace

Result<DeviceAddress> DeviceAddress::parse(std::string_view text) {
  const std::size_t colon = text.find(':');
  const Scheme* const of_path = find_scheme_of_path(text);
  const Scheme* const scheme = of_path != nullptr ? of_path
                               : colon == std::string_view::npos
                                   ? nullptr
                                   : find_scheme(text.substr(0, colon));
  if (scheme == nullptr)
    return wrong(text, "must begin with one of " + known_schemes() +
                           "; example: " + std::string(kSchemes[0].example));
  const bool is_whole = of_path != nullptr || scheme->kind == TransportKind::kStream;
  std::string_view rest = is_whole ? text : text.substr(colon + 1);
  Result<DeviceAddress> address = DeviceAddress{.kind = scheme->kind};
  // Question marks in URLs and pipelines are theirs.
  if (scheme->kind != TransportKind::kStream && scheme->kind != TransportKind::kGstreamer)
    address = with_options(*address, rest);
  if (!address) return wrong(text, address.error().detail());
  // file:///data/a.mp4
  while (scheme->kind == TransportKind::kFile && rest.starts_with("//")) rest.remove_prefix(1);

  std::optional<std::string> problem = problem_of_options(*address);
  if (!problem && (address->kind == TransportKind::kTcp || address->kind == TransportKind::kUdp)) {
    problem = take_host_and_port(*address, rest);
  } else if (!problem) {
    address->place = rest;
    problem = problem_of_place(*address);
  }
  if (problem) return wrong(text, *problem + "; example: " + std::string(scheme->example));
  return address;
}

std::string DeviceAddress::to_string() const {
  if (kind == TransportKind::kStream) return place;
  std::string text(scheme_of(kind).name);
  text += ':';
  const bool in_brackets = port != 0 && place.find(':') != std::string::npos;
  text += in_brackets ? '[' + place + ']' : place;
  if (port != 0) text += ':' + std::to_string(port);
  char before = '?';
  for (const auto& [name, value] : options) {
    text.append(1, before).append(name).append(1, '=').append(value);
    before = '&';
  }
  return text;
}

std::string DeviceAddress::shown() const { return without_passwords(to_string()); }

std::string without_passwords(std::string text) {
  for (std::size_t at = text.find("://"); at != std::string::npos; at = text.find("://", at)) {
    at += 3;
    const std::size_t end = text.find_first_of("/?# \t\"'", at);
    const std::size_t host = text.rfind('@', end);
    if (host == std::string::npos || host < at) continue;
    const std::size_t colon = text.find(':', at);
    if (colon < host) text.replace(colon + 1, host - colon - 1, "***");
  }
  return text;
}

std::uint32_t DeviceAddress::baud(std::uint32_t otherwise) const {
  const auto found = options.find("baud");
  if (found == options.end()) return otherwise;
  return base::parse_number<std::uint32_t>(found->second).value_or(otherwise);
}

std::uint32_t DeviceAddress::can_bit_rate() const {
  const auto found = options.find("can");
  if (found == options.end()) return 0;
  return base::parse_number<std::uint32_t>(found->second).value_or(0);
}

double DeviceAddress::speed() const {
  const auto found = options.find("speed");
  if (found == options.end()) return 1;
  return base::parse_number<double>(found->second).value_or(0);
}

double DeviceAddress::rate() const {
  const auto found = options.find("rate");
  if (found == options.end()) return 0;
  return base::parse_number<double>(found->second).value_or(0);
}

bool DeviceAddress::loops() const {
  const auto found = options.find("loop");
  return found != options.end() && found->second == "1";
}

Result<DeviceAddress> serial_device(std::int32_t number) {
  constexpr std::array<std::string_view, 3> kKinds = {"ttyS", "ttyUSB", "ttyACM"};
  const std::int32_t kind = number / kNumbersOfAKind;
  if (number < 0 || kind >= static_cast<std::int32_t>(kKinds.size()))
    return Error(Errc::kInvalidArgument,
                 "unknown serial device " + std::to_string(number) +
                     ": valid are 0 to 99 (ttyS), 100 to 199 (ttyUSB), 200 to 299 (ttyACM)");
  return DeviceAddress{.kind = TransportKind::kSerial,
                       .place = "/dev/" + std::string(kKinds.at(static_cast<std::size_t>(kind))) +
                                std::to_string(number % kNumbersOfAKind)};
}

Result<DeviceAddress> can_device(std::int32_t number) {
  if (number < 0 || number >= kNumbersOfAKind)
    return Error(Errc::kInvalidArgument, "unknown CAN device " + std::to_string(number) +
                                             ": valid are 0 to 99 (can0 to can99)");
  return DeviceAddress{.kind = TransportKind::kCan, .place = "can" + std::to_string(number)};
}

std::string guid_text(std::uint64_t guid) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[guid >> shift & 0xFU];
  return text;
}

Result<DeviceAddress> dcam_device(std::string_view guid) {
  constexpr std::uint64_t kLowerHalf = 0xFFFFFFFF;
  const bool is_hex = guid.starts_with("0x") || guid.starts_with("0X");
  std::optional<std::uint64_t> number = is_hex
                                            ? base::parse_number<std::uint64_t>(guid.substr(2), 16)
                                            : base::parse_number<std::uint64_t>(guid);
  if (!number)
    if (const auto negative = base::parse_number<std::int32_t>(guid))
      number = static_cast<std::uint32_t>(*negative);
  if (!number)
    return Error(Errc::kInvalidArgument,
                 "cameraGuid must be 0 (first camera) or a GUID, for example 0x00b09d0100a1b2c3, "
                 "not " +
                     base::in_quotes(guid));
  DeviceAddress address{.kind = TransportKind::kDcam, .place = "0"};
  if (*number != 0) address.place = guid_text(*number).substr(*number > kLowerHalf ? 0 : 8);
  return address;
}

}  // namespace rack::device
