#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <google/protobuf/descriptor.h>

/// Protobuf enumerators as words of the command line: `seen_through` is EVENT_REASON_SEEN_THROUGH
/// without the prefix of its type.
namespace steadymap {

/// Returns the word for an enumerator; `unknown` for a number without a name in this program, and
/// for 0 (UNSPECIFIED). `type` is `v1::Something_descriptor()`.
std::string WordOf(const google::protobuf::EnumDescriptor* type, int number);

/// Returns the enumerator of a word; 0 for an unknown word.
int NumberOf(const google::protobuf::EnumDescriptor* type, std::string_view word);

/// Returns all words of a type in numerical order, separated by commas.
std::string WordsOf(const google::protobuf::EnumDescriptor* type);

}  // namespace steadymap
