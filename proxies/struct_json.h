// Structs and messages in JSON, as message files (catalogue.h) and the description of the whole
// catalogue (catalogue_text.h) contain them. The format is described in README.md.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "rack/proxies/catalogue.h"

namespace rack {

// The structs that a list contains already.
using StructsThere = std::vector<const Schema*>;

// Appends a struct to a list, after the structs that it contains; each of them once.
void append_struct(std::string& out, StructsThere& there, const Schema& schema);
// Appends the messages of a class to a list, one a line, behind `indent` blanks.
void append_messages(std::string& out, std::span<const MessageInfo> messages, std::size_t indent);

// "CameraData.image", the first Tail of a struct; empty: it has none.
std::string tail_in(const Schema& schema);

}  // namespace rack
