// Messages of classes that RACK does not define, described in files. The author of a component
// installs a description of its messages with it, and timsctl and DatalogRec can decode them like
// the messages of RACK.
//
// A file is JSON and is generated from the structs when the component is built (message_file() of
// rack/proxies/catalogue.h). Files are looked for
//   in $RACK_MESSAGES, files and directories separated by colons;
//   in share/rack/messages next to the program's bin, of /usr/local and of /usr.
// The first file that describes a class has priority.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/catalogue.h"

namespace rack {

// The checked content of a file; the data that it returns refers to it.
class MessageFile {
 public:
  // kMalformed states the position and the problem. The result is safe to use, whatever the text
  // contains: all sizes are bounded, and no struct contains itself.
  static Result<std::unique_ptr<MessageFile>> parse(std::string_view text);

  [[nodiscard]] const ClassInfo& class_info() const { return class_; }

 private:
  friend class MessageFileReader;
  MessageFile() = default;

  std::deque<std::string> texts_;
  std::deque<std::vector<SchemaField>> fields_;
  std::deque<std::vector<std::byte>> made_;
  std::deque<Schema> structs_;
  std::vector<MessageInfo> messages_;
  ClassInfo class_;
};

// Where files are looked for, and that RACK_MESSAGES is not set: for errors about unknown classes.
std::string message_places();

// Adds all files found to the catalogue, until the program ends. Call it before the program starts
// threads. Returns the problems of the invalid files.
std::vector<std::string> load_message_files();

}  // namespace rack
