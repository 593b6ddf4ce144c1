// A component that produces data: the last data sets are kept, sent to listeners, and found again
// by their time (specification, section 6).
//
//   class Scanner : public rack::DataModule<rack::LadarData> {
//     Result<void> module_loop() override {
//       rack::LadarData& scan = get_local_buffer();
//       ...                                  // recordingTime first of all
//       return put_local_buffer();           // keeps it, and sends it
//     }
//   };
#pragma once

#include <memory>
#include <variant>
#include <vector>

#include "rack/data_history.h"
#include "rack/module.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

struct DataInfo {
  std::uint32_t history = 10;    // data sets that can be asked for
  std::size_t size_max = 0;      // of the body of one, bytes
  std::uint32_t listeners = 64;  // at most
  // A newer data set makes an older one worthless: links short of bandwidth leave out the older.
  bool samples = true;
};

// All of it that does not depend on the struct.
class DataModuleBase : public Module {
 public:
  DataModuleBase(const ModuleInfo& info, const DataInfo& data);
  ~DataModuleBase() override;

 protected:
  Result<void> module_command(const tims::MessageView& message) override;
  // Calls module_loop() until there are data: who has turned this on can ask for them.
  Result<void> module_on() override;

  // Of the data, ms; in module_on(), before DataModule::module_on(). 0 cannot be turned on.
  void set_period(std::chrono::milliseconds period);
  [[nodiscard]] std::chrono::milliseconds period() const;

  std::span<std::byte> workspace() { return history_.workspace(); }
  void publish(TimeStamp recorded, std::size_t size);

  // The data set of a time that was asked for, into `to`; returns its size. By default the nearest;
  // a component may interpolate. Called with mutex_ held.
  virtual Result<std::size_t> data_at(TimeStamp time, std::span<std::byte> to) const;
  [[nodiscard]] const DataHistory& history() const { return history_; }
  static tims::Error not_there(DataHistory::Miss miss, TimeStamp time);

 private:
  void turned_off() override;

  class [[gnu::visibility("hidden")]] Publisher;  // who gets the data

  const DataInfo data_;
  DataHistory history_;  // under mutex_, but for the workspace, which is the data task's
  std::unique_ptr<Publisher> publisher_;
};

template <Struct Data>
class DataModule : public DataModuleBase {
 public:
  DataModule(const ModuleInfo& info, const DataInfo& data) : DataModuleBase(info, with_size(data)) {
    reserve_all(local_buffer_);
  }

 protected:
  // Where the data task makes the next data set; keeps what was in it.
  Data& get_local_buffer() { return local_buffer_; }
  // kInvalidArgument: it cannot be sent as it is, or is larger than DataInfo::size_max.
  Result<void> put_local_buffer() {
    const auto size = encode(local_buffer_, workspace());
    if (!size) return size.error();
    publish(local_buffer_.recordingTime, *size);
    return {};
  }

  // data_at() of who interpolates: what `between` makes of the data sets before and after `time`,
  // and `time`. After the newest, but not by more than `ahead`, these are the newest two.
  using Between = Data (*)(const Data& before, const Data& after, TimeStamp time);
  Result<std::size_t> data_between(TimeStamp time, std::chrono::milliseconds ahead,
                                   std::span<std::byte> to, Between between) const {
    const auto found = history().around(time, ahead);
    if (const auto* miss = std::get_if<DataHistory::Miss>(&found)) return not_there(*miss, time);
    const auto& pair = std::get<DataHistory::Pair>(found);
    const auto before = decode<Data>(pair.before.body);
    const auto after = decode<Data>(pair.after.body);
    if (!before) return before.error();
    if (!after) return after.error();
    return encode(between(*before, *after, time), to);
  }
  // The same, but after the newest that one is the answer, as by default: what has jumped, or
  // stopped, is not carried on.
  Result<std::size_t> data_between(TimeStamp time, std::span<std::byte> to, Between between) const {
    if (time - history().newest().recorded >= std::chrono::milliseconds(0))
      return DataModuleBase::data_at(time, to);
    return data_between(time, {}, to, between);
  }

 private:
  static DataInfo with_size(DataInfo data) {
    if (data.size_max == 0) data.size_max = body_max<Data>();
    return data;
  }
  Data local_buffer_{};
};

}  // namespace rack

#pragma GCC visibility pop
