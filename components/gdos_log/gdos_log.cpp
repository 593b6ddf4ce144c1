// gdos-log: stores the log texts of all components.
#include "rack/proxies/gdos_log.h"

#include <array>
#include <chrono>
#include <optional>
#include <utility>

#include "components/gdos_log/text_files.h"
#include "os/clock.h"
#include "proxies/gdos_texts.h"
#include "rack/data_module.h"

namespace rack::gdos_log {
namespace {

constexpr auto kLook = std::chrono::milliseconds(100);
constexpr auto kTryAgain = std::chrono::milliseconds(500);  // to open the sink
// Period of an empty message to listeners when there are no texts, so that a loss is noticed.
constexpr auto kPeriod = std::chrono::milliseconds(5000);
constexpr int kAtOnce = 256;

constexpr std::array<ParameterInfo, 8> kParameters = {{
    // The sink itself is instance 0 of system 0.
    {"instance", 1, "instance id", 0, kIdMax},
    {"targetStatus", 1, "1: turn on at start", 0, 1},
    host_file({"directory", "",
               "folder of the files; empty: /var/log/tims for root, else ~/.local/state/tims"}),
    {"fileSize", 10240, "maximum size of a file [KiB]", 1, 1 << 21},
    {"files", 10, "maximum number of files, including the current one", 1, 100000},
    {"age", 0, "maximum age of a file [days]; 0: limited by `files` only", 0, 36500},
    {"syncTime", 1000,
     "interval between syncs to disk [ms]; later texts are lost at a power failure", 10, 3600000},
    one_of("-1 only as a service of systemd, 0 no, 1 yes",
           {"journal", -1, "write to journald, too", -1, 1}),
}};

constexpr ModuleInfo kInfo{
    .program = "gdos-log",
    .purpose = "Stores the log texts of all components.",
    .class_id = tims::class_id::kGdos,
    .parameters = kParameters,
};

gdos::RecordTime wall_now() {
  return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

class GdosLog : public DataModule<GdosData> {
 public:
  GdosLog() : DataModule(kInfo, {.history = 100, .samples = false}) {}

 private:
  Result<void> module_init() override {
    if (address() != tims::text_sink(address_widths())) return {};
    return tims::Error(tims::Errc::kInvalidArgument, address().to_string(address_widths()) +
                                                         " is the sink itself; use --instance 1");
  }

  Result<void> module_on() override {
    const bool asked = integer("journal") == 1;
    const bool by_systemd = integer("journal") < 0 && runs_under_journal();
    writer_.emplace(log(), std::chrono::milliseconds(integer("syncTime")), asked || by_systemd);
    const TextFileLimits limits{
        .bytes = static_cast<std::uint64_t>(integer("fileSize")) << 10,
        .files = static_cast<std::uint32_t>(integer("files")),
        .age = std::chrono::days(integer("age")),
    };
    if (auto good = writer_->open(folder(), limits); !good) return good;
    owner_.clear();
    next_try_ = next_sign_ = {};
    set_period(kPeriod);
    take_sink();
    return DataModule::module_on();
  }

  [[nodiscard]] std::filesystem::path folder() const {
    const std::string given = text("directory");
    return given.empty() ? gdos::folder_to_write() : std::filesystem::path(given);
  }

  void module_off() override {
    sink_.reset();
    writer_.reset();
  }

  Result<void> module_loop() override {
    if (sink_) {
      take_texts();
    } else {
      sleep_until_next(kLook);
      take_sink();
    }
    const tims::Time now = tims::os::now();
    for (const auto& [sender, count] : limits_.take_suppressed(now))
      pass_on(sender, gdos::Level::kWarning,
              std::to_string(count) + " texts suppressed: too many at once");
    writer_->on_time(now);
    if (now < next_sign_) return {};
    next_sign_ = now + kPeriod;
    return publish_data({.address = address(), .level = {}});
  }

  Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != GdosLogType::kGetTexts) return DataModule::module_command(message);
    const std::string lines = newest_lines(folder(), kGdosTextsMax);
    GdosTexts texts;
    texts.text.assign(lines.begin(), lines.end());
    reply(message.header, GdosLogType::kTexts, texts);
    return {};
  }

  // --- the sink

  // A router of the original allows one owner of the sink only, which may be the graphical
  // interface.
  void take_sink() {
    const tims::Time now = tims::os::now();
    if (now < next_try_) return;
    next_try_ = now + kTryAgain;
    auto opened = open_mailbox(
        {.address = tims::text_sink(address_widths()), .slots = 1024, .body_max = 1024});
    if (opened) {
      sink_.emplace(std::move(*opened));
      lost_ = 0;
      owner_.clear();
      log().print("Texts are kept in {}", folder().string());
    } else if (owner_ != opened.error().message()) {
      owner_ = opened.error().message();
      log().warning("Waits for the sink of texts: {}", owner_);
    }
  }

  void take_texts() {
    auto message = sink_->peek_for(kLook);
    for (int i = 0; message && i < kAtOnce; ++i) {
      take(*message);
      message->release();
      message = sink_->try_peek();
    }
    if (!message && message.error().code() != tims::Errc::kTimeout &&
        message.error().code() != tims::Errc::kEmpty)
      return sink_.reset();  // another program owns it since the router was restarted
    report_lost();
  }

  void take(const tims::PeekGuard& message) {
    const tims::Header& header = message.header();
    const auto level = gdos::level_of(header.type);
    if (!level) return answer(header);
    if (!limits_.take(tims::os::now(), header.src, *level)) return;
    const auto text = gdos::decode(message.body(), header.body_order(), address_widths());
    pass_on(header.src, *level, text ? *text : text.error().detail() + " (malformed)");
  }

  // Answers requests for the texts with the address of this component.
  void answer(const tims::Header& request) {
    if (request.type <= 0) return;
    std::array<std::byte, wire_size<GdosLogAddress>()> body{};
    const bool asked = request.type == GdosLogType::kGetLog;
    if (asked && encode(GdosLogAddress{.log = address()}, body)) {
      (void)sink_->reply(request, GdosLogType::kLog, body);
    } else {
      (void)sink_->reply(request, tims::type::kError);
    }
  }

  // Reports texts that arrived faster than they could be written.
  void report_lost() {
    const tims::MailboxCounters counters = sink_->counters();
    const std::uint64_t lost = counters.replaced + counters.refused + counters.too_big;
    if (lost == lost_) return;
    pass_on(address(), gdos::Level::kWarning,
            std::to_string(lost - lost_) + " texts lost: too many at once");
    lost_ = lost;
  }

  // --- texts

  void pass_on(tims::Address sender, gdos::Level level, const std::string& text) {
    const gdos::Record record{.time = wall_now(),
                              .address = sender,
                              .component = sender.to_string(address_widths()),
                              .level = level,
                              .text = gdos::to_utf8(text)};
    writer_->write(record);
    (void)publish_data(record);
  }

  Result<void> publish_data(const gdos::Record& record) {
    GdosData& data = get_local_buffer();
    data.recordingTime = TimeStamp::of(record.time.time_since_epoch());
    data.sender = record.address;
    data.level = static_cast<i32>(record.level);
    data.text.assign(record.text.begin(), record.text.end());
    return put_local_buffer();
  }

  // Used by the data task only.
  std::optional<TextWriter> writer_;
  std::optional<tims::Mailbox> sink_;
  SenderLimits limits_;
  std::string owner_;  // owner of the sink, as last logged
  std::uint64_t lost_ = 0;
  tims::Time next_try_{};
  tims::Time next_sign_{};
};

}  // namespace
}  // namespace rack::gdos_log

int main(int argc, char** argv) {
  rack::gdos_log::GdosLog log;
  return log.run(argc, argv);
}
