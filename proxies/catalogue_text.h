// Descriptions of all messages of RACK for programs in other languages: RACK's console reads and
// writes every message by them. tims-schema prints them, and console/src/codec contains them, so
// that the console is built without a compiler for C++.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rack/proxies/catalogue.h"

namespace rack {

// The bodies of all messages of RACK, each struct once.
std::vector<const Schema*> own_bodies();

// All classes, structs and messages as JSON (README.md).
std::string catalogue_json();
// The same as types of TypeScript.
std::string catalogue_types();

// Bodies with arbitrary content, so that another codec can be compared with this one. One vector a
// line:
//
//   STRUCT little|big BODY RESULT
//
// BODY in hex, "-" if it is empty. RESULT is the body in JSON (to_json()), or "!" and the error of
// a body that is not valid. For every body, its truncations that are valid follow as vectors; all
// others are not.
std::string catalogue_vectors(std::uint64_t seed);

}  // namespace rack
