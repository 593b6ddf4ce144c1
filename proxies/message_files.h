// Messages of classes that are none of RACK's, out of files: whoever makes a component installs
// what its messages look like beside it, and timsctl and DatalogRec know their fields like ours.
//
// A file is JSON, made by the build of the component from its structs (message_file() of
// rack/proxies/catalogue.h), so that nothing is said twice. It is looked for
//   in $RACK_MESSAGES, files and folders separated by colons;
//   in share/rack/messages beside the program's bin, of /usr/local and of /usr.
// The first that speaks of a class is the one.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/catalogue.h"

namespace rack {

// Everything a file says, checked; what it is told of refers to it.
class MessageFile {
 public:
  // kMalformed says where what was wrong. Whatever the text holds, what comes out can be used: all
  // sizes are bounded, and no struct holds itself.
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

// Makes all that are found known to find_message(), for as long as the program runs; before its
// first thread. Returns what was wrong with the others.
std::vector<std::string> load_message_files();

}  // namespace rack
