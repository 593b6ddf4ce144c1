// What sources of this folder share about keys.
#pragma once

#include <string_view>

#include "security/crypto/digest.h"

namespace tims::security {

Digest hash_of_public_key(evp_pkey_st* key);
bool is_p256(const evp_pkey_st* key);
bool verify_signature(evp_pkey_st* key, View data, View signature);

// A BIO that reads the text, which must outlive it.
Handle<bio_st> reading(std::string_view text);
// What was written into a memory BIO.
std::string written(bio_st* bio);

}  // namespace tims::security
