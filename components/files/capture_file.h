// Writes a capture while a driver runs: the driver's thread only appends to a buffer, another
// thread writes it to the file. If the disk is full or slow, records are lost and counted, but the
// driver is never delayed.
//
// An existing recording is continued: a driver that opens its device again, or is restarted after a
// crash, does not erase the events that led to it.
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "components/files/log_file.h"
#include "rack/devices/capture.h"

namespace rack::device {

class CaptureFile {
 public:
  // `device`: address for the header line. kInvalidArgument: the file exists and is not a
  // recording.
  static tims::Result<std::unique_ptr<CaptureFile>> create(const std::string& path,
                                                           std::string_view device,
                                                           tims::Time begin);
  ~CaptureFile();

  void add(tims::Time when, Direction direction, std::uint32_t id, std::span<const std::byte> bytes,
           tims::Duration took = {});
  void add_event(tims::Time when, std::string_view event);

  // Number of records missing in the file so far.
  [[nodiscard]] std::uint64_t lost() const;
  // A message for the log since the last call: the file cannot be written, or can be written again.
  std::optional<std::string> take_event();
  // Writes the rest of the buffer; nothing can be added after that.
  void finish();

 private:
  CaptureFile(LogFile file, std::string path, tims::Time begin);
  template <typename Append>
  void append(std::size_t room, Append append);
  void write_until_ended();
  void on_written(std::string_view text, const tims::Result<void>& written);

  LogFile file_;
  const std::string path_;
  const tims::Time begin_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::string waiting_;               // under mutex_
  std::uint64_t lost_ = 0;            // under mutex_
  std::uint64_t reported_ = 0;        // lost records already reported, under mutex_
  bool failed_ = false;               // under mutex_
  bool ended_ = false;                // under mutex_
  std::optional<std::string> event_;  // under mutex_
  std::thread writer_;
};

}  // namespace rack::device
