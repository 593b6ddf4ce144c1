#include "tests/bench/device_latency.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include <poll.h>
#include <unistd.h>

#include "components/devices/io/line.h"
#include "components/devices/scanners/lms200_emulator.h"
#include "components/devices/scanners/sick_cola_emulator.h"
#include "libtims/os/clock.h"
#include "rack/devices/device.h"
#include "rack/devices/device_clock.h"
#include "rack/proxies/ladar.h"
#include "tests/bench/launch.h"
#include "tests/bench/metrics.h"
#include "tests/bench/usage.h"
#include "tests/support/tcp_socket.h"
#include "tims/session.h"

namespace tims::bench {
namespace {

namespace device = rack::device;
namespace emulator = rack::device::emulator;
using Bytes = std::vector<std::byte>;

constexpr std::uint32_t kBaud = 500000;
constexpr std::size_t kAnswersMax = 200;  // bytes; longer telegrams are scans
constexpr std::uint32_t kScansASecond = 75;

// --- the time of the first byte of a scan, encoded in its first distances, one byte each

constexpr std::size_t kMarks = sizeof(std::int64_t);
constexpr unsigned kNearest = 1000;  // mm: smaller values may be error codes

unsigned mark_of(Time time, std::size_t index) {
  const auto ns = static_cast<std::uint64_t>(time.time_since_epoch().count());
  return kNearest + static_cast<unsigned>(ns >> 8 * index & 0xFF);
}

// The time stored in the first distances of a scan; `distance(i)` returns that of point i.
Time marked(const std::function<unsigned(std::size_t)>& distance) {
  std::uint64_t ns = 0;
  for (std::size_t i = 0; i < kMarks; ++i)
    ns |= std::uint64_t{(distance(i) - kNearest) & 0xFF} << 8 * i;
  return Time(Duration(static_cast<Duration::rep>(ns)));
}

// The telegrams of a scanner, and the position of the distances in them.
struct Telegrams {
  bool is_serial = false;
  const char* driver;
  // Length of the telegram at the start of the bytes; 0: incomplete; nothing: no telegram starts
  // here.
  std::optional<std::size_t> (*telegram_size)(std::span<const std::byte> bytes);
  unsigned (*distance)(std::span<const std::byte> telegram, std::size_t index);
  void (*set_distance)(std::span<std::byte> telegram, std::size_t index, unsigned distance);
  void (*seal)(std::span<std::byte> telegram);
  Bytes (*start)();  // the command that starts the measurement
  std::size_t (*size_of_points)(std::size_t points);
};

constexpr std::size_t kLmsFirst = 7;
constexpr std::size_t kLmsFrame = 6;

constexpr Telegrams kLms200{
    .is_serial = true,
    .driver = "LadarSickLms200",
    .telegram_size = [](std::span<const std::byte> bytes) -> std::optional<std::size_t> {
      if (bytes[0] != std::byte{2}) return std::nullopt;
      if (bytes.size() < 4) return 0;
      return device::little_endian<std::uint16_t>(bytes, 2) + kLmsFrame;
    },
    .distance = [](std::span<const std::byte> telegram, std::size_t index) -> unsigned {
      return device::little_endian<std::uint16_t>(telegram, kLmsFirst + 2 * index);
    },
    .set_distance =
        [](std::span<std::byte> telegram, std::size_t index, unsigned distance) {
          telegram[kLmsFirst + 2 * index] = static_cast<std::byte>(distance);
          telegram[kLmsFirst + 2 * index + 1] = static_cast<std::byte>(distance >> 8);
        },
    .seal =
        [](std::span<std::byte> telegram) {
          const std::size_t end = telegram.size() - 2;
          const std::uint16_t crc = device::lms200_crc(telegram.first(end));
          telegram[end] = static_cast<std::byte>(crc);
          telegram[end + 1] = static_cast<std::byte>(crc >> 8);
        },
    .start =
        [] {
          constexpr std::array kPartsAsTheyCome = {std::byte{0x20}, std::byte{0x2A}};
          Bytes command;
          device::append_lms200(command, kPartsAsTheyCome);
          return command;
        },
    .size_of_points = [](std::size_t points) { return kLmsFirst + 2 * points + 3; },
};

constexpr std::size_t kColaHead = 8;

// After the name of the channel: factor, offset, first angle, step, and number of values.
std::size_t cola_values(std::span<const std::byte> telegram) {
  constexpr std::string_view kChannel = "DIST1";
  const std::string_view text(reinterpret_cast<const char*>(telegram.data()), telegram.size());
  return text.find(kChannel) + kChannel.size() + 16;
}

void append_command(Bytes& out, const std::function<void(Bytes&)>& write) {
  Bytes body;
  write(body);
  device::append_cola(out, device::ColaDialect::kBinary, body);
}

Bytes cola_start() {
  constexpr auto kBinary = device::ColaDialect::kBinary;
  constexpr std::uint8_t kAuthorised = 3;
  Bytes commands;
  append_command(commands, [](Bytes& body) {
    device::ColaWriter(kBinary, body, "sMN SetAccessMode")
        .put(kAuthorised)
        .put(emulator::SickColaEmulatorSettings{}.password);
  });
  append_command(commands,
                 [](Bytes& body) { device::ColaWriter(kBinary, body, "sMN LMCstartmeas"); });
  append_command(commands, [](Bytes& body) {
    device::ColaWriter(kBinary, body, "sEN LMDscandata").put(std::uint8_t{1});
  });
  return commands;
}

constexpr Telegrams kCola{
    .driver = "LadarSickCola",
    .telegram_size = [](std::span<const std::byte> bytes) -> std::optional<std::size_t> {
      if (bytes[0] != std::byte{2}) return std::nullopt;
      if (bytes.size() < kColaHead) return 0;
      return kColaHead + device::big_endian<std::uint32_t>(bytes, 4) + 1;
    },
    .distance = [](std::span<const std::byte> telegram, std::size_t index) -> unsigned {
      return device::big_endian<std::uint16_t>(telegram, cola_values(telegram) + 2 * index);
    },
    .set_distance =
        [](std::span<std::byte> telegram, std::size_t index, unsigned distance) {
          const std::size_t at = cola_values(telegram) + 2 * index;
          telegram[at] = static_cast<std::byte>(distance >> 8);
          telegram[at + 1] = static_cast<std::byte>(distance);
        },
    .seal =
        [](std::span<std::byte> telegram) {
          std::byte sum{};
          for (const std::byte byte : telegram.subspan(kColaHead, telegram.size() - kColaHead - 1))
            sum ^= byte;
          telegram.back() = sum;
        },
    .start = cola_start,
    .size_of_points = [](std::size_t) -> std::size_t { return 0; },
};

const Telegrams& scanner_of(const Plan& plan) { return plan.link == "lms200" ? kLms200 : kCola; }

Duration line_time_of(const Telegrams& scanner, std::size_t bytes) {
  return scanner.is_serial ? device::line_time(bytes, kBaud) : Duration(0);
}

std::string emulated_address(const Plan& plan) {
  return scanner_of(plan).is_serial ? "pty:" + plan.folder + "/scanner" : "tcp:" + plan.endpoint;
}

// --- the scanner

// The emulator, with the time of the first byte stored in each scan.
class MarkedScanner final : public device::Dialogue {
 public:
  MarkedScanner(const Telegrams& scanner, Dialogue& emulated)
      : scanner_(scanner), emulated_(emulated) {}

  void start(Time now, device::Output& out) override { emulated_.start(now, *through(out)); }
  void on_arrival(const device::Arrival& arrival, device::Output& out) override {
    emulated_.on_arrival(arrival, *through(out));
  }
  void on_timeout(Time now, device::Output& out) override {
    emulated_.on_timeout(now, *through(out));
  }
  [[nodiscard]] Time next_timeout() const override { return emulated_.next_timeout(); }

 private:
  struct Marker final : device::Output {
    explicit Marker(const Telegrams& its_scanner) : scanner(its_scanner) {}

    void send(std::span<const std::byte> bytes, std::uint32_t id) override {
      if (bytes.size() <= kAnswersMax) return out->send(bytes, id);
      telegram.assign(bytes.begin(), bytes.end());
      const Time now = os::now();
      for (std::size_t i = 0; i < kMarks; ++i) scanner.set_distance(telegram, i, mark_of(now, i));
      scanner.seal(telegram);
      out->send(telegram, id);
    }
    void set_baud(std::uint32_t baud) override { out->set_baud(baud); }

    const Telegrams& scanner;
    device::Output* out = nullptr;
    Bytes telegram{};
  };

  Marker* through(device::Output& out) {
    marker_.out = &out;
    return &marker_;
  }

  const Telegrams& scanner_;
  Dialogue& emulated_;
  Marker marker_{scanner_};
};

// --- the readers

class Samples {
 public:
  Samples(const Telegrams& scanner, pid_t reader, std::uint64_t wanted)
      : scanner_(scanner), reader_(reader), wanted_(wanted) {
    lateness_.reserve(wanted);
  }

  // Records a scan of `bytes` bytes whose first byte was sent at `sent`. False: enough scans.
  bool take(Time sent, std::size_t bytes, Time now) {
    if (lateness_.empty()) {
      before_ = usage_of(reader_);
      began_ = now;
    }
    lateness_.push_back(now - sent - line_time_of(scanner_, bytes));
    return lateness_.size() < wanted_;
  }

  bool print() {
    if (lateness_.size() < wanted_) return false;
    constexpr double kPercent = 100;
    const Usage spent = usage_of(reader_) - before_;
    const std::chrono::duration<double> passed = os::now() - began_;
    print_latencies(lateness_);  // sorts them
    // An implausible time: the scans were not those of this emulator.
    if (lateness_.front() < Duration(0) || lateness_.back() > std::chrono::seconds(1)) {
      std::fprintf(stderr, "scans arrived %lld ns after they were sent\n",
                   static_cast<long long>(lateness_.front().count()));
      return false;
    }
    print_metric("max_us", static_cast<double>(lateness_.back().count()) * 1e-3);
    print_metric("cpu_percent", kPercent * spent.cpu_s / passed.count());
    return true;
  }

 private:
  const Telegrams& scanner_;
  pid_t reader_;
  std::uint64_t wanted_;
  std::vector<Duration> lateness_;
  Usage before_;
  Time began_{};
};

Result<test::ChildProcess> start_device(Plan& plan) {
  if (auto free = test::listen_tcp()) plan.endpoint = free->endpoint();
  Plan its = plan;
  its.role = "device";
  std::vector<std::string> command{std::filesystem::read_symlink("/proc/self/exe")};
  for (std::string& argument : to_arguments(its)) command.push_back(std::move(argument));
  auto process = launch(std::move(command), false);
  if (!process) return process.error();
  if (auto ready = process->wait_for_line("sends", kStartLimit); !ready) return ready.error();
  return process;
}

Result<test::ChildProcess> start_driver(const Plan& plan) {
  const Telegrams& scanner = scanner_of(plan);
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename(scanner.driver);
  std::vector<std::string> command{program, "--router=" + plan.socket};
  if (scanner.is_serial) {
    command.push_back("--device=serial:" + plan.folder + "/scanner");
    command.push_back("--baudrate=" + std::to_string(kBaud));
    command.emplace_back("--protocol=1");  // partial scans as they are measured
  } else {
    command.push_back("--device=tcp:" + plan.endpoint);
    command.emplace_back("--periodTime=" + std::to_string(1000 / kScansASecond));
  }
  return launch(std::move(command), false);
}

bool listen(const Plan& plan, Samples& samples, const Telegrams& scanner) {
  auto session = Session::connect({.name = "listener", .router = plan.socket});
  if (!session) return complain(session.error());
  const auto address = [](std::uint32_t local) {
    return Address::of({.class_id = class_id::kTest, .instance = 0, .local = local});
  };
  auto work = session->open({.address = address(0), .slots = 4, .body_max = 128});
  auto data = session->open(
      {.address = address(1), .slots = 4, .body_max = rack::body_max<rack::LadarData>()});
  if (!work || !data) return false;
  rack::LadarProxy ladar(*work, Address::of({.class_id = class_id::kLadar}));
  const Time give_up = os::now() + kStartLimit;  // its program may still be starting
  while (!ladar.on() && os::now() < give_up) {
  }
  if (auto wanted = ladar.get_cont_data(0, data->address()); !wanted)
    return complain(wanted.error());
  rack::LadarData scan;
  for (bool has_more = true; has_more;) {
    const auto message = data->peek_for(kStartLimit);
    const Time now = os::now();
    if (!message) return complain(message.error());
    if (!ladar.decode_stream(*message, scan)) return false;
    // Scans are clockwise, so the first distance that the scanner sends is the last point.
    const Time sent = marked([&](std::size_t i) {
      return static_cast<unsigned>(scan.points[scan.points.size() - 1 - i].distance);
    });
    has_more = samples.take(sent, scanner.size_of_points(scan.points.size()), now);
  }
  return true;
}

Result<os::File> open_bare(const Plan& plan, std::unique_ptr<device::Transport>& line) {
  if (!scanner_of(plan).is_serial) return test::connect_tcp(plan.endpoint, kStartLimit);
  auto opened = device::open_transport(
      {.kind = device::TransportKind::kSerial, .place = plan.folder + "/scanner"}, kBaud);
  if (!opened) return opened.error();
  line = std::move(*opened);
  return os::File(::dup(line->descriptor()));
}

// Only splits a stream into telegrams.
bool read_scans(int file, const Telegrams& scanner, Samples& samples) {
  Bytes buffer(1 << 16);
  std::size_t filled = 0;
  for (;;) {
    pollfd there{.fd = file, .events = POLLIN, .revents = 0};
    if (::poll(&there, 1, 10'000) <= 0) return false;
    const ssize_t size = ::read(file, buffer.data() + filled, buffer.size() - filled);
    const Time now = os::now();
    if (size <= 0) return false;
    filled += static_cast<std::size_t>(size);
    std::span<const std::byte> rest(buffer.data(), filled);
    while (!rest.empty()) {
      const auto telegram = scanner.telegram_size(rest);
      if (telegram && (*telegram == 0 || *telegram > rest.size())) break;
      if (telegram && *telegram > kAnswersMax) {
        const auto whole = rest.first(*telegram);
        const Time sent = marked([&](std::size_t i) { return scanner.distance(whole, i); });
        if (!samples.take(sent, whole.size(), now)) return true;
      }
      rest = rest.subspan(telegram.value_or(1));
    }
    std::memmove(buffer.data(), rest.data(), rest.size());
    filled = rest.size();
  }
}

}  // namespace

bool play_device(const Plan& plan) {
  emulator::Lms200Emulator lms200({.baud = kBaud});
  emulator::SickColaEmulator cola({.device = "LMS511",
                                   .scan_frequency = kScansASecond * 100,
                                   .start_angle = -50000,
                                   .values = 381,
                                   .spin_up = std::chrono::milliseconds(10)});
  const Telegrams& scanner = scanner_of(plan);
  device::Dialogue& emulated = scanner.is_serial ? static_cast<device::Dialogue&>(lms200) : cola;
  MarkedScanner device(scanner, emulated);
  const auto address = device::DeviceAddress::parse(emulated_address(plan));
  if (!address) return complain(address.error());
  auto line = device::open_line(*address, kBaud);
  if (!line) return complain(line.error());
  const auto connected = device::Device::with(std::move(*line), device);
  std::puts("sends");
  std::fflush(stdout);
  for (;;)
    if (auto waited = connected->wait(kNever); !waited) return complain(waited.error());
}

bool listen_to_driver(const Plan& plan) {
  Plan here = plan;
  auto scanner = start_device(here);
  if (!scanner) return complain(scanner.error());
  auto driver = start_driver(here);
  if (!driver) return complain(driver.error());
  Samples samples(scanner_of(plan), driver->pid(), plan.count);
  if (listen(plan, samples, scanner_of(plan)) && samples.print()) return true;
  std::fputs(driver->output().c_str(), stderr);
  return false;
}

bool read_bare(const Plan& plan) {
  Plan here = plan;
  auto device = start_device(here);
  if (!device) return complain(device.error());
  std::unique_ptr<device::Transport> line;
  const auto file = open_bare(here, line);
  if (!file) return complain(file.error());
  const Telegrams& scanner = scanner_of(plan);
  const Bytes start = scanner.start();
  if (::write(file->get(), start.data(), start.size()) != static_cast<ssize_t>(start.size()))
    return complain(os::system_error("write"));
  Samples samples(scanner, ::getpid(), plan.count);
  return read_scans(file->get(), scanner, samples) && samples.print();
}

}  // namespace tims::bench
