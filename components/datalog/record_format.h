// What becomes of a message in a recording of the original's format (specification, section 11).
// Pure.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "rack/codec/schema.h"
#include "tims/message.h"
#include "tims/result.h"

namespace rack::datalog {

// What is written for one message.
struct Record {
  std::string line{};         // of the .dat file
  std::string_view suffix{};  // of a file of its own, ".2d"; empty: none
  std::string file{};
  std::string_view raw_suffix{};  // of another one
  std::string raw{};
};

struct RecordedClass {
  std::uint32_t class_id;
  std::string_view title;    // in its files: "Scan2d"
  std::string_view name;     // of its files: "scan2d"
  std::int32_t instances;    // in the built-in list: from 0 on
  std::size_t body_max;      // bytes
  std::string_view columns;  // the second line of its files
  // file_number: of the file of its own, if there is one. Of a class that was made known: null.
  tims::Result<Record> (*record)(const tims::MessageView& message, std::uint32_t file_number,
                                 bool binary_io);
  const Schema* data = nullptr;
};
tims::Result<Record> record(const RecordedClass& recorded, const tims::MessageView& message,
                            std::uint32_t file_number, bool binary_io);

// In the order of the built-in list. Behind those of the original come the data of all classes that
// were made known (add_class() of the catalogue) before this is called: all their fields, one
// instance.
std::span<const RecordedClass> recorded_classes();
const RecordedClass* recorded_class(std::uint32_t class_id);  // nullptr: is not recorded

// The first two lines of a file.
std::string heading(const RecordedClass& recorded, tims::Address module,
                    const tims::AddressWidths& widths = {});

}  // namespace rack::datalog
