#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <google/protobuf/descriptor.h>

/// The wire's enumerators as words of the command line: `seen_through` is EVENT_REASON_SEEN_THROUGH
/// without what all enumerators of its type begin with.
namespace steadymap {

/// The word for an enumerator; `unknown` for a number that this program has no name for, and for
/// the one that means "not given". `type` is `v1::Something_descriptor()`.
std::string WordOf(const google::protobuf::EnumDescriptor* type, int number);

/// The enumerator that a word stands for; 0 for a word that stands for none.
int NumberOf(const google::protobuf::EnumDescriptor* type, std::string_view word);

/// All words of a type, in the order of their numbers, separated by commas.
std::string WordsOf(const google::protobuf::EnumDescriptor* type);

}  // namespace steadymap
