// timsctl device: devices of this host, and their recordings. Needs no router.
#include <algorithm>
#include <array>
#include <charconv>

#include <fmt/format.h>
#include <poll.h>

#include "base/measure.h"
#include "base/text.h"
#include "components/devices/io/device_monitor.h"
#include "components/devices/io/host_devices.h"
#include "components/devices/io/line.h"
#include "components/files/capture_file.h"
#include "components/recordings/capture_statistics.h"
#include "os/clock.h"
#include "rack/devices/recording.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"

namespace timsctl {

using namespace rack::device;
using namespace std::chrono_literals;

namespace {

constexpr std::uint32_t kBaud = 115200;  // if the address does not contain one

std::string joined(const std::vector<std::string>& texts, std::string_view between) {
  return fmt::format("{}", fmt::join(texts, between));
}

// --- devices of this host

json::object to_json(const HostDevice& device) {
  json::object item{{"kind", name(device.kind)},
                    {"node", device.node},
                    {"address", device_address(device)},
                    {"device", device_text(device)},
                    {"programs", programs_text(device)},
                    {"path", device.path},
                    {"stable", device.stable},
                    {"kernel_driver", device.driver},
                    {"missing_text", joined(what_is_missing(device), "; ")}};
  json::array missing;
  for (const std::string& text : what_is_missing(device)) missing.emplace_back(text);
  item["missing"] = std::move(missing);
  json::array users;
  for (const std::string& user : device.used_by) users.emplace_back(user);
  item["used_by"] = std::move(users);
  for (const char* text :
       {"address", "device", "programs", "path", "stable", "kernel_driver", "missing_text"})
    if (item[text].as_string().empty()) item[text] = nullptr;
  if (device.bit_rate) item["bit_rate"] = *device.bit_rate;
  if (!device.can_state.empty()) item["can_state"] = device.can_state;
  if (device.latency_ms) item["latency_ms"] = *device.latency_ms;
  if (device.usb) {
    item["usb"] = {{"id", fmt::format("{:04x}:{:04x}", device.usb->vendor, device.usb->product)},
                   {"serial_number", device.usb->serial_number},
                   {"text", device.usb->text}};
  }
  return item;
}

constexpr Column kDeviceColumns[] = {
    {"ADDRESS", "address"},
    {"DEVICE", "device"},
    {"PROGRAMS", "programs"},
    {"MISSING", "missing_text"},
    {"KIND", "kind", Cell::kText, true},
    {"NODE", "node", Cell::kText, true},
    {"USB", "usb.id", Cell::kText, true},
    {"SERIAL NUMBER", "usb.serial_number", Cell::kText, true},
    {"KERNEL DRIVER", "kernel_driver", Cell::kText, true},
};

void print(Output& out, const DeviceChange& change) {
  const HostDevice& device = change.device;
  json::object line = to_json(device);
  const base::WallTime now = tims::os::wall_now();
  if (out.json()) {
    line["schema"] = "tims/device_event/1";
    line["time"] = base::rfc3339(now, 3);
    line["event"] = change.is_there ? "plugged" : "unplugged";
    return out.write(line);
  }
  const std::string address = device_address(device);
  std::string text = fmt::format("{} {:<9} {}  {}", time_of_day(now, out.look().utc),
                                 change.is_there ? "plugged" : "unplugged",
                                 address.empty() ? device.node : address, device_text(device));
  const std::string programs = programs_text(device);
  if (change.is_there && !programs.empty()) text += "  -> " + programs;
  if (const std::string missing = joined(what_is_missing(device), "; ");
      change.is_there && !missing.empty())
    text += "  (" + missing + ")";
  const Tone tone = change.is_there ? Tone::kGood : Tone::kWarning;
  out.write(paint(base::printable(text), tone, out.look().colour) + "\n");
}

}  // namespace

Exit device_list(Context& context) {
  json::array items;
  for (const HostDevice& device : host_devices()) items.emplace_back(to_json(device));
  if (!context.options.sort.empty()) sort_items(items, kDeviceColumns, context.options.sort);
  if (items.empty()) context.out.note("there is no device for which a driver is available");
  return show_list(context, "tims/device_list/1", std::move(items), kDeviceColumns);
}

Exit device_watch(Context& context) {
  constexpr auto kLookEvery = 1s;   // polling interval without udev events
  constexpr auto kSettled = 200ms;  // a device is reported part by part: port, interface, terminal
  std::uint64_t left = context.options.count.value_or(UINT64_MAX);
  const tims::Time end = context.run_end();
  auto events = DeviceMonitor::open();
  std::vector<HostDevice> known = host_devices();
  context.out.note(fmt::format("{} devices found; waiting for changes", known.size()));
  while (left > 0 && tims::os::now() < end) {
    const tims::Time look = std::min<tims::Time>(end, tims::os::deadline_after(kLookEvery));
    if (events &&
        context.signals.wait(events->descriptor(), look) == Signals::WaitResult::kReadable) {
      context.signals.sleep_until(tims::os::deadline_after(kSettled));
      events->take_events();
    } else if (!events) {
      context.signals.sleep_until(look);
    }
    std::vector<HostDevice> now = host_devices();
    for (const DeviceChange& change : changes(known, now)) {
      if (left == 0) break;
      --left;
      print(context.out, change);
    }
    known = std::move(now);
  }
  return left > 0 && context.options.count ? Exit::kTimeout : Exit::kDone;
}

// --- device record: recording of a device without a driver

namespace {

DeviceAddress need_device(const std::string& text) {
  auto address = DeviceAddress::parse(text);
  if (!address) throw usage_error(address.error().detail(), "timsctl device list shows addresses");
  return *address;
}

class Recorder {
 public:
  Recorder(Context& context, const DeviceAddress& address, const std::string& path)
      : context_(context),
        address_(address),
        path_(path),
        left_(context.options.count.value_or(UINT64_MAX)) {
    auto transport = open_transport(address, kBaud);
    if (!transport)
      throw Failure(Exit::kNoSuch, "no_device", transport.error().detail(),
                    "`timsctl device list` shows the devices");
    transport_ = std::move(*transport);
    began_ = tims::os::now();
    auto file = CaptureFile::create(path, address.to_string(), began_);
    if (!file) throw Failure(Exit::kDenied, "denied", file.error().detail());
    file_ = std::move(*file);
  }

  Exit run() {
    context_.out.note(
        fmt::format("recording {} to {}; stop with Ctrl-C", transport_->description(), path_));
    const tims::Time end = context_.run_end();
    try {
      while (left_ > 0 && tims::os::now() < end && !(transport_ && transport_->is_over()))
        turn(end);
    } catch (const Interrupted&) {
      summary();
      throw;
    }
    summary();
    return Exit::kDone;
  }

 private:
  static constexpr auto kTryEvery = 300ms;

  void turn(tims::Time end) {
    if (!transport_) return open_again();
    const tims::Time next = std::min(end, transport_->next_timeout());
    (void)context_.signals.wait(transport_->descriptor(), next);
    const auto received = transport_->receive(tims::os::now(), [this](const Arrival& arrival) {
      if (left_ == 0) return;
      --left_;
      ++records_;
      bytes_ += arrival.bytes.size();
      file_->add(arrival.last, arrival.is_sent ? Direction::kSent : Direction::kReceived,
                 arrival.id, arrival.bytes);
    });
    if (!received) write_event(received.error().detail(), false);
  }

  void open_again() {
    context_.signals.sleep_until(tims::os::deadline_after(kTryEvery));
    auto transport = open_transport(address_, kBaud);
    if (!transport) return;
    transport_ = std::move(*transport);
    write_event("the device is back", true);
  }

  void write_event(const std::string& text, bool is_there) {
    file_->add_event(tims::os::now(), text);
    context_.out.note(text);
    if (!is_there) transport_.reset();
  }

  void summary() {
    const Duration took = tims::os::now() - began_;
    file_->finish();
    const std::uint64_t lost = file_->lost();
    context_.out.write(
        json::object{{"schema", "tims/recorded/1"},
                     {"device", address_.to_string()},
                     {"file", path_},
                     {"records", records_},
                     {"bytes", bytes_},
                     {"lost", lost},
                     {"duration_s", base::seconds(took)}},
        [&] {
          std::string text = fmt::format("{} records, {}, in {}\n", records_,
                                         base::human_bytes(static_cast<double>(bytes_)),
                                         base::human_duration(base::seconds(took)));
          if (lost > 0)
            text += fmt::format("{} records were lost: the disk was full or too slow\n", lost);
          return text;
        });
  }

  Context& context_;
  DeviceAddress address_;
  std::string path_;
  std::uint64_t left_;
  std::unique_ptr<Transport> transport_;
  tims::Time began_{};
  std::unique_ptr<CaptureFile> file_;
  std::uint64_t records_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace

Exit device_record(Context& context) {
  const std::vector<std::string>& arguments = context.options.arguments;
  return Recorder(context, need_device(arguments[0]), arguments[1]).run();
}

// --- device play: the content of a recording, or its playback to a program

namespace {

// "FILE", "FILE?speed=2", "play:FILE".
DeviceAddress recording_of(const std::string& text) {
  return need_device(text.starts_with("play:") ? text : "play:" + text);
}

Failure bad_recording(const DeviceAddress& file, const tims::Error& error) {
  const bool is_missing = error.code() == tims::Errc::kSystem;
  const bool is_named = error.detail().find(file.place) != std::string::npos;
  return {is_missing ? Exit::kNoSuch : Exit::kNo, is_missing ? "no_such_file" : "bad_recording",
          (is_named ? "" : file.place + ": ") + error.detail()};
}

json::object sum_of(const CaptureStatistics::Sum& sum) {
  return {{"records", sum.records}, {"bytes", sum.bytes}};
}

json::object to_json(const CaptureStatistics& statistics, const Recording& recording,
                     const std::string& path) {
  const double duration = base::seconds(statistics.duration());
  const auto bytes = static_cast<double>(statistics.received().bytes);
  json::object all{{"schema", "tims/recording/1"},
                   {"file", path},
                   {"format", recording.format()},
                   {"duration_s", duration},
                   {"received", sum_of(statistics.received())},
                   {"sent", sum_of(statistics.sent())},
                   {"rate_bytes_per_s", duration > 0 ? json::value(bytes / duration) : nullptr},
                   {"longest_gap_s", base::seconds(statistics.longest_gap())},
                   {"longest_gap_at_s", base::seconds(statistics.longest_gap_at())},
                   {"gaps", statistics.gaps()},
                   {"backwards", statistics.backwards()},
                   {"event_count", statistics.event_count()}};
  if (const std::string remarks = recording.remarks(); !remarks.empty()) all["remarks"] = remarks;
  json::array events;
  for (const auto& event : statistics.events())
    events.push_back({{"time_s", base::seconds(event.time)}, {"text", event.text}});
  all["events"] = std::move(events);
  json::array ids;
  for (const auto& [id, sum] : statistics.by_id())
    ids.push_back(
        {{"id", fmt::format("{:03X}", id)}, {"records", sum.records}, {"bytes", sum.bytes}});
  all["ids"] = std::move(ids);
  return all;
}

constexpr Column kStatisticsLines[] = {
    {"Format", "format"},
    {"Duration", "duration_s", Cell::kDuration},
    {"Received records", "received.records", Cell::kCount},
    {"Received bytes", "received.bytes", Cell::kBytes},
    {"Bytes per second", "rate_bytes_per_s", Cell::kRate},
    {"Sent records", "sent.records", Cell::kCount},
    {"Sent bytes", "sent.bytes", Cell::kBytes},
    {"Longest gap", "longest_gap_s", Cell::kDuration},
    {"Longest gap at", "longest_gap_at_s", Cell::kDuration},
    {"Gaps", "gaps", Cell::kCount},
    {"Backward steps", "backwards", Cell::kCount, false, true},
    {"Events", "event_count", Cell::kCount},
};
constexpr Column kEventColumns[] = {{"AT", "time_s", Cell::kDuration}, {"EVENT", "text"}};
constexpr Column kIdColumns[] = {
    {"ID", "id"}, {"RECORDS", "records", Cell::kCount}, {"BYTES", "bytes", Cell::kBytes}};

Exit show_statistics(Context& context, const DeviceAddress& file) {
  auto recording = open_recording(file, kBaud);
  if (!recording) throw bad_recording(file, recording.error());
  CaptureStatistics statistics;
  CaptureRecord record;
  std::uint64_t count = 0;
  for (auto got = (*recording)->next(record);; got = (*recording)->next(record)) {
    if (!got) throw bad_recording(file, got.error());
    if (!*got) break;
    statistics.add(record);
    constexpr std::uint64_t kLookEvery = 4096;
    if (++count % kLookEvery == 0) context.signals.sleep_until({});  // Ctrl-C
  }
  const json::object answer = to_json(statistics, **recording, file.place);
  context.out.write(answer, [&] {
    const Look& look = context.out.look();
    std::string text = render_page(answer, kStatisticsLines, look);
    for (const auto& [list, columns] : {std::pair{"events", std::span<const Column>(kEventColumns)},
                                        std::pair{"ids", std::span<const Column>(kIdColumns)}})
      if (!items_of(answer, list).empty())
        text += "\n" + render_items(items_of(answer, list), columns, look);
    if (const std::string remarks = (*recording)->remarks(); !remarks.empty())
      text += "\n" + remarks + "\n";
    return text;
  });
  return Exit::kDone;
}

// Plays a recording to the program that opens the line.
class Player {
 public:
  Player(Context& context, const DeviceAddress& file, const DeviceAddress& to)
      : context_(context), file_(file), is_port_(to.kind == TransportKind::kTcp) {
    auto playback = open_transport(file, to.baud(kBaud));
    if (!playback) throw bad_recording(file, playback.error());
    playback_ = std::move(*playback);
    // The recording determines the timing.
    auto line = open_line(to, to.options.contains("baud") ? kBaud : 0);
    if (!line) throw Failure(Exit::kDenied, "denied", line.error().detail());
    line_ = std::move(*line);
    context.out.note(fmt::format("playing {} at {}; stop with Ctrl-C", file.place, to.to_string()));
  }

  Exit run() {
    const tims::Time end = context_.run_end();
    while (!is_there() && tims::os::now() < end) wait(std::min(end, line_->next_timeout()));
    while (!is_done() && tims::os::now() < end) {
      wait(std::min({end, playback_->next_timeout(), line_->next_timeout(), retry()}));
      play();
    }
    if (const auto remarks = playback_->take_event()) context_.out.note(*remarks);
    // When a terminal is closed, its reader loses all unread bytes.
    constexpr auto kLinger = 500ms;
    context_.signals.sleep_until(std::min<tims::Time>(end, tims::os::deadline_after(kLinger)));
    const json::object answer{
        {"schema", "tims/played/1"}, {"file", file_.place}, {"bytes", bytes_}};
    context_.out.write(
        answer, [&] { return base::human_bytes(static_cast<double>(bytes_)) + " played\n"; });
    return Exit::kDone;
  }

 private:
  // Sending an empty piece to a port tests whether a client is connected; on a bus it would be a
  // frame.
  bool is_there() {
    if (!is_port_) return true;
    const auto taken = line_->send(tims::os::now(), {}, 0);
    return taken && *taken;
  }
  [[nodiscard]] bool is_done() const { return playback_->is_over() && waiting_.empty(); }
  [[nodiscard]] tims::Time retry() const {
    return waiting_.empty() ? tims::kNever : tims::Time(tims::os::deadline_after(2ms));
  }

  // Bytes that programs send to the device are discarded.
  void wait(tims::Time until) {
    (void)context_.signals.wait(line_->descriptor(), until);
    if (auto received = line_->receive(tims::os::now(), [](const Arrival&) {}); !received)
      throw Failure(Exit::kNo, "no_device", received.error().detail());
  }

  void play() {
    const tims::Time now = tims::os::now();
    if (waiting_.empty()) {
      const auto played = playback_->receive(now, [this](const Arrival& arrival) {
        if (arrival.is_sent) return;
        waiting_.emplace_back(arrival.id, std::vector(arrival.bytes.begin(), arrival.bytes.end()));
      });
      if (!played) throw bad_recording(file_, played.error());
    }
    std::size_t done = 0;
    for (; done < waiting_.size(); ++done) {
      const auto& [id, piece] = waiting_[done];
      const auto taken = line_->send(now, piece, id);
      if (!taken || !*taken) break;
      bytes_ += piece.size();
    }
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(done));
  }

  Context& context_;
  DeviceAddress file_;
  bool is_port_;
  std::unique_ptr<Transport> playback_;
  std::unique_ptr<Transport> line_;
  std::vector<std::pair<std::uint32_t, std::vector<std::byte>>> waiting_;
  std::uint64_t bytes_ = 0;
};

}  // namespace

Exit device_play(Context& context) {
  const std::vector<std::string>& arguments = context.options.arguments;
  const DeviceAddress file = recording_of(arguments[0]);
  if (arguments.size() == 1) return show_statistics(context, file);
  return Player(context, file, need_device(arguments[1])).run();
}

}  // namespace timsctl
