// DatalogRec: writes the data of other components to files.
#include <algorithm>
#include <array>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "components/datalog/record_format.h"
#include "components/files/file_folder.h"
#include "components/files/log_file.h"
#include "os/clock.h"
#include "os/file.h"
#include "proxies/message_files.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/proxies/datalog.h"
#include "rack/proxies/proxy.h"

namespace rack::datalog {
namespace {

constexpr std::uint32_t kSmall = 20 << 10;
constexpr std::uint32_t kLarge = 1 << 20;
constexpr std::size_t kListBytesMax = 1 << 20;
constexpr auto kSilence = std::chrono::seconds(2);  // at least five periods
constexpr auto kAskAgain = std::chrono::seconds(2);
// Every component answers GET_STATUS within it.
constexpr auto kStatusWait = std::chrono::milliseconds(80);
constexpr auto kIdle = std::chrono::milliseconds(200);
constexpr auto kLook = std::chrono::milliseconds(20);  // large messages are received in between

// The list is built at the start, and by INIT_LOG.
constexpr std::array<ParameterInfo, 4> kParameters = {
    ParameterInfo{"binaryIo", 0, "1: write values of Io and points of Scan3d in binary form", 0, 1},
    host_file(at_start({"logInfoFileName", "",
                        "list of modules: address in hexadecimal or by name, blank, file name"})),
    host_file(at_start({"logPathName", "",
                        "folder of the files, with a slash at its end, and the beginning of their "
                        "names; at most 39 characters; empty: the folder of RACK_FILES"})),
    at_start({"record", "",
              "modules that are recorded without SET_LOG: \"Ladar(0/0), Thermometer(0/0)\""}),
};

constexpr ModuleInfo kInfo{
    .program = "DatalogRec",
    .purpose = "Writes the data of other components to files.",
    .class_id = tims::class_id::kDatalog,
    .parameters = kParameters,
};

// One recorded component: its stream and its file.
class Recorder {
 public:
  // entry: its place in the list. `stream`: the mailbox for its data.
  Recorder(std::size_t entry, const DatalogLogInfo& info, const RecordedClass& recorded,
           tims::Mailbox& work, tims::Address stream)
      : entry_(entry),
        info_(info),
        recorded_(&recorded),
        proxy_(work, info.moduleMbx, {.data = std::chrono::seconds(1)}),
        stream_(stream),
        widths_(work.address_widths()) {}

  [[nodiscard]] tims::Address module() const { return proxy_.component(); }
  [[nodiscard]] std::chrono::milliseconds period() const { return period_; }
  [[nodiscard]] std::size_t entry() const { return entry_; }
  [[nodiscard]] const DatalogLogInfo& info() const { return info_; }

  Result<void> create(const FileFolder& folder, const std::string& name);
  // Turns the component on and subscribes.
  Result<void> subscribe(tims::Time now);
  void stop() { (void)proxy_.stop_cont_data(stream_); }

  // Writes a message of its stream. A failure is logged once; the message is skipped.
  void take(const tims::MessageView& message, tims::Time now, bool binary_io, TextLog& log);
  // Whether no message was received for long: the component may have been restarted, which requires
  // a new subscription.
  [[nodiscard]] bool is_silent(tims::Time now) const;
  void ask_again(tims::Time now, TextLog& log);

 private:
  Result<void> write(const Record& record);

  std::size_t entry_;
  DatalogLogInfo info_;  // take() counts there
  const RecordedClass* recorded_;
  Proxy proxy_;
  tims::Address stream_;
  tims::AddressWidths widths_;
  std::optional<FileFolder> folder_;
  std::string base_;  // name without its extension
  LogFile file_;
  std::chrono::milliseconds period_{};
  tims::Time last_received_{};
  tims::Time asked_{};
  bool ended_ = false;    // the component has ended its stream
  bool failing_ = false;  // the last message was not written
};

// Begins a file of the recording.
Result<LogFile> new_log(const FileFolder& folder, const std::string& name) {
  auto created = folder.create(name);
  if (!created) return created.error();
  LogFile file;
  file.begin(std::move(*created), folder.path_of(name));
  return file;
}

Result<void> Recorder::create(const FileFolder& folder, const std::string& name) {
  folder_ = folder;
  base_ = base_of(name);
  auto created = new_log(folder, name);
  if (!created) return created.error();
  file_ = std::move(*created);
  return file_.append(heading(*recorded_, info_.moduleMbx, widths_));
}

Result<void> Recorder::subscribe(tims::Time now) {
  asked_ = now;
  if (auto on = proxy_.on(); !on) return on;
  const auto granted = proxy_.get_cont_data(info_.periodTime, stream_);
  if (!granted) return granted.error();
  period_ = std::chrono::milliseconds(granted->raw());
  last_received_ = now;
  ended_ = false;
  return {};
}

void Recorder::take(const tims::MessageView& message, tims::Time now, bool binary_io,
                    TextLog& log) {
  last_received_ = now;
  if (const auto good = check_data(message.header, module(), widths_); !good) {
    ended_ = true;
    return log.warning("{} has no data now", module());
  }
  const auto made = record(*recorded_, message, info_.setsLogged + 1, binary_io);
  const auto written = made ? write(*made) : made.error();
  if (!written && !failing_) log.error("Not recorded, {}: {}", module(), written.error().message());
  if (written && failing_) log.print("Recorded again: {}", module());
  failing_ = !written;
}

// The line is written last, since it refers to the other files.
Result<void> Recorder::write(const Record& record) {
  std::size_t bytes = record.line.size();
  const auto beside = [&](std::string_view suffix, const std::string& content) -> Result<void> {
    if (suffix.empty()) return {};
    bytes += content.size();
    auto file =
        new_log(*folder_, base_ + "_" + std::to_string(info_.setsLogged + 1) + std::string(suffix));
    return file ? file->append(content) : file.error();
  };
  if (auto good = beside(record.suffix, record.file); !good) return good;
  if (auto good = beside(record.raw_suffix, record.raw); !good) return good;
  if (auto good = file_.append(record.line); !good) return good;
  info_.bytesLogged = info_.bytesLogged + static_cast<u32>(bytes);
  ++info_.setsLogged;
  return {};
}

bool Recorder::is_silent(tims::Time now) const {
  return ended_ || now - last_received_ > std::max<tims::Duration>(kSilence, 5 * period_);
}

void Recorder::ask_again(tims::Time now, TextLog& log) {
  if (now - asked_ < kAskAgain) return;
  if (const auto asked = subscribe(now); asked) log.info("{} sends again", module());
}

class DatalogRec : public DataModule<DatalogData> {
 public:
  DatalogRec() : DataModule(kInfo, {.history = 10}) {}

 private:
  Result<void> module_init() override {
    for (const std::string& problem : load_message_files()) log().warning("{}", problem);
    return make_list();
  }

  // --- the list

  Result<void> make_list() {
    const std::string path = text("logInfoFileName");
    std::vector<DatalogLogInfo> list;
    if (path.empty()) {
      list = built_in();
    } else {
      const auto content = tims::os::read_file(path, kListBytesMax);
      if (!content) return content.error();
      const auto read = read_list(*content, address_widths());
      if (!read) return with_places(read.error(), path + ", ");
      list = *read;
    }
    DatalogData made;
    made.logInfo.assign(list.begin(), list.end());
    if (const auto added = add_wanted(made); !added) return added;
    const std::lock_guard lock(list_mutex_);
    if (recording_) return {};
    list_.logInfo = made.logInfo;
    log_path_ = text("logPathName");
    if (!list_.logPathName.assign(log_path_))
      return refused("logPathName has more than 39 characters");
    for (const DatalogLogInfo& info : list_.logInfo)
      if (!is_plain_name(info.filename.view()))
        return refused("\"" + std::string(info.filename.view()) +
                       "\" is not the name of a file, without a path");
    return {};
  }

  // The modules of the parameter `record`.
  Result<void> add_wanted(DatalogData& list) const {
    auto modules = modules_of(text("record"), address_widths());
    if (!modules) return with_places(modules.error(), "record = " + text("record") + ": ");
    DatalogData wanted;
    for (DatalogLogInfo& info : *modules) {
      info.logEnable = 1;
      wanted.logInfo.push_back(info);
    }
    const auto changed = change_list(list, wanted, address_widths());
    return changed ? changed : with_places(changed.error(), "");
  }

  // Errors about unknown classes state where the descriptions of messages were looked for.
  static tims::Error with_places(const tims::Error& error, const std::string& before) {
    const std::string& detail = error.detail();
    const bool unknown = detail.find("no class is called") != std::string::npos ||
                         detail.find("are not recorded") != std::string::npos;
    return {error.code(), before + detail + (unknown ? ": " + message_places() : "")};
  }

  // --- names of files

  // The folder and the beginning of the names of all files, as logPathName gives them.
  struct Place {
    FileFolder folder;
    std::string beginning;
  };
  [[nodiscard]] Result<Place> place() const {
    const std::string& path = log_path_;
    if (path.empty()) {
      auto folder = FileFolder::of_messages();
      if (!folder) return folder.error();
      return Place{*folder, ""};
    }
    const std::size_t slash = path.rfind('/');
    if (slash == std::string::npos) return Place{FileFolder("."), path};
    return Place{FileFolder(path.substr(0, slash + 1)), path.substr(slash + 1)};
  }

  // The name in the folder of place(). A list from a message may make the beginning of all names
  // longer, but cannot leave the folder.
  [[nodiscard]] Result<std::string> name_of(const DatalogData& list,
                                            const DatalogLogInfo& info) const {
    const auto where = place();
    if (!where) return where.error();
    const std::string& given = log_path_;
    const std::string_view wanted = list.logPathName.view();
    if (!wanted.starts_with(given))
      return refused("logPathName = " + std::string(wanted) + ": must begin with " +
                     (given.empty() ? "a plain name, in " + where->folder.path() : given) +
                     "; the folder is changed by the recorder's parameter logPathName");
    std::string name = where->beginning + std::string(wanted.substr(given.size())) +
                       std::string(info.filename.view());
    if (!is_plain_name(name))
      return refused("\"" + name + "\" is not the name of a file in " + where->folder.path());
    return name;
  }

  [[nodiscard]] Result<void> check_names(const DatalogData& list) const {
    for (const DatalogLogInfo& info : list.logInfo)
      if (const auto name = name_of(list, info); !name) return name.error();
    return {};
  }

  [[nodiscard]] std::vector<DatalogLogInfo> built_in() const {
    std::vector<DatalogLogInfo> list;
    for (const RecordedClass& recorded : recorded_classes()) {
      for (std::int32_t i = 0; i < recorded.instances; ++i) {
        if (list.size() == decltype(list_.logInfo)::kMax) return list;
        DatalogLogInfo info{.moduleMbx = address_of(recorded.class_id, integer("system"), i),
                            .maxDataLen = static_cast<i32>(recorded.body_max)};
        (void)info.filename.assign(std::string(recorded.name) + "_" + std::to_string(i) + ".dat");
        list.push_back(info);
      }
    }
    return list;
  }

  // --- recording

  Result<void> module_on() override {
    first_ = true;
    binary_io_ = integer("binaryIo") != 0;
    small_->clean();
    large_->clean();
    if (auto created = create_recorders(); !created) return created;
    if (auto started = start_recorders(); !started) return started;
    return DataModule::module_on();
  }

  Result<void> create_recorders() {
    const DatalogData list = begin_recording();
    const auto where = place();
    if (!where) return where.error();
    for (std::size_t i = 0; i < list.logInfo.size(); ++i) {
      const DatalogLogInfo& info = list.logInfo[i];
      if (info.logEnable == 0) continue;
      const RecordedClass* recorded =
          recorded_class(info.moduleMbx.fields(address_widths()).class_id);
      if (recorded == nullptr)
        return with_places(log_info(info.moduleMbx, address_widths()).error(), "");
      const OwnMailbox& stream = info.maxDataLen <= static_cast<i32>(kSmall) ? small_ : large_;
      Recorder& recorder = recorders_.emplace_back(i, info, *recorded, *work_, stream->address());
      const auto name = name_of(list, info);
      if (!name) return name.error();
      if (auto created = recorder.create(where->folder, *name); !created) {
        // A full disk may have room later; a missing folder is a permanent error.
        log().error("{}", created.error().message());
        if (created.error().code() != tims::Errc::kDiskFull) return created;
      }
    }
    return {};
  }

  // The list, with counters that begin at 0.
  DatalogData begin_recording() {
    const std::lock_guard lock(list_mutex_);
    recording_ = true;
    for (DatalogLogInfo& info : list_.logInfo)
      if (info.logEnable != 0) info.bytesLogged = info.setsLogged = 0;
    return list_;
  }

  // The list is not locked while others are asked and files are written: commands are answered
  // meanwhile.
  Result<void> start_recorders() {
    auto shortest = std::chrono::milliseconds(1000);
    for (Recorder& recorder : recorders_) {
      if (auto on = recorder.subscribe(tims::os::now()); !on) return on;
      shortest = std::min(shortest, recorder.period());
    }
    set_period(shortest);
    return {};
  }

  void module_off() override {
    for (Recorder& recorder : recorders_) recorder.stop();
    recorders_.clear();
    const std::lock_guard lock(list_mutex_);
    recording_ = false;
  }

  Result<void> module_loop() override {
    if (std::exchange(first_, false)) return publish_list();
    const tims::Time end = tims::os::now() + kIdle;
    for (tims::Time now = tims::os::now(); now < end; now = tims::os::now()) {
      const auto large = large_->try_peek();
      if (large) return take(*large);
      const auto small = small_->peek_for(kLook);
      if (small) return take(*small);
    }
    ask_silent_ones();
    return {};
  }

  Result<void> take(const tims::PeekGuard& message) {
    const auto from = std::ranges::find(recorders_, message.header().src, &Recorder::module);
    if (from == recorders_.end()) return {};
    from->take({message.header(), message.body()}, tims::os::now(), binary_io_, log());
    {
      const std::lock_guard lock(list_mutex_);
      DatalogLogInfo& info = list_.logInfo[from->entry()];
      info.bytesLogged = from->info().bytesLogged;
      info.setsLogged = from->info().setsLogged;
    }
    ask_silent_ones();
    return publish_list();
  }

  void ask_silent_ones() {
    const tims::Time now = tims::os::now();
    for (Recorder& recorder : recorders_) {
      if (recorder.is_silent(now)) recorder.ask_again(now, log());
    }
  }

  Result<void> publish_list() {
    {
      const std::lock_guard lock(list_mutex_);
      get_local_buffer() = list_;
    }
    get_local_buffer().recordingTime = time_stamp();
    return put_local_buffer();
  }

  // --- commands

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case DatalogType::kInitLog:
        return answered_later(message,
                              [this] { return is_recording() ? Result<void>() : make_list(); });
      case DatalogType::kSetLog:
        return set_log(message);
      case DatalogType::kGetLogStatus:
        if (is_recording()) return send_log_status(message.header);
        return later(message, [this](const tims::Header& request) {
          forget_absent();
          return send_log_status(request);
        });
      default:
        return DataModule::module_command(message);
    }
  }

  // Takes effect with the next ON, like all settings; the current recording continues.
  Result<void> set_log(const tims::MessageView& message) {
    const auto wanted = decode<DatalogData>(message);
    if (!wanted) return wanted.error();
    {
      const std::lock_guard lock(list_mutex_);
      if (wanted->logInfo.size() != list_.logInfo.size()) return change_some(*wanted, message);
      if (auto good = check_names(*wanted); !good) return good;
      list_.logPathName = wanted->logPathName;
      for (std::size_t i = 0; i < list_.logInfo.size(); ++i) {
        DatalogLogInfo& info = list_.logInfo[i];
        const DatalogLogInfo old = std::exchange(info, wanted->logInfo[i]);
        if (!recording_) continue;
        info.bytesLogged = old.bytesLogged;
        info.setsLogged = old.setsLogged;
      }
    }
    reply(message.header, tims::type::kOk);
    return {};
  }

  // A list with some modules only, such as one by name. list_mutex_ is held.
  Result<void> change_some(const DatalogData& wanted, const tims::MessageView& message) {
    DatalogData changed;
    changed.logInfo = list_.logInfo;
    if (const auto good = change_list(changed, wanted, address_widths()); !good)
      return with_places(good.error(), "");
    changed.logPathName =
        wanted.logPathName.view().empty() ? list_.logPathName : wanted.logPathName;
    if (auto good = check_names(changed); !good) return good;
    list_.logPathName = changed.logPathName;
    list_.logInfo.resize(changed.logInfo.size());
    std::ranges::copy(changed.logInfo, list_.logInfo.begin());
    reply(message.header, tims::type::kOk);
    return {};
  }

  Result<void> send_log_status(const tims::Header& request) {
    std::vector<std::byte> body(DatalogData::kWholeSize);
    {
      const std::lock_guard lock(list_mutex_);
      list_.recordingTime = time_stamp();
      if (const auto size = encode(list_, body); !size) return size.error();
    }
    reply(request, DatalogType::kLogStatus, body);
    return {};
  }

  bool is_recording() {
    const std::lock_guard lock(list_mutex_);
    return recording_;
  }

  // Removes components that do not exist, or are in error. All of them are asked at once; one that
  // has not answered after kStatusWait stays.
  void forget_absent() {
    status_->clean();
    std::vector<tims::Address> absent;
    std::size_t asked = 0;
    for (const tims::Address module : modules()) {
      const auto sent =
          status_->send({.dest = module, .type = tims::type::kGetStatus, .report_if_gone = true});
      if (sent)
        ++asked;
      else
        absent.push_back(module);
    }
    const tims::Time end = tims::os::now() + kStatusWait;
    for (; asked > 0; --asked) {
      const auto answer = status_->peek_for(std::max(end - tims::os::now(), tims::Duration(0)));
      if (!answer) break;
      const tims::Header& header = answer->header();
      if (header.type == tims::type::kNotAvailable ||
          header.type == static_cast<i8>(Status::kError))
        absent.push_back(header.src);
    }
    const std::lock_guard lock(list_mutex_);
    if (recording_) return;
    std::erase_if(list_.logInfo, [&](const DatalogLogInfo& info) {
      return std::ranges::find(absent, info.moduleMbx) != absent.end();
    });
  }

  std::vector<tims::Address> modules() {
    const std::lock_guard lock(list_mutex_);
    std::vector<tims::Address> modules;
    for (const DatalogLogInfo& info : list_.logInfo) modules.push_back(info.moduleMbx);
    return modules;
  }

  OwnMailbox work_{*this, 1, 128};
  OwnMailbox small_{*this, 500, kSmall};
  OwnMailbox large_{*this, 10, kLarge};
  bool binary_io_ = false;
  bool first_ = true;
  OwnMailbox status_{*this, decltype(DatalogData::logInfo)::kMax, 128};  // of the worker
  std::deque<Recorder> recorders_;  // of the enabled components in the list; of the data task
  PriorityMutex list_mutex_;        // protects the members below
  DatalogData list_;
  std::string log_path_;    // logPathName when the list was made; constant while recording
  bool recording_ = false;  // the recorders refer to entries of the list, which stay in place
};

}  // namespace
}  // namespace rack::datalog

int main(int argc, char** argv) {
  rack::datalog::DatalogRec recorder;
  return recorder.run(argc, argv);
}
