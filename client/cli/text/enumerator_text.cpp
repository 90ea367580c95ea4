#include "client/cli/text/enumerator_text.h"

#include <algorithm>
#include <cctype>

namespace steadymap {
namespace {

// The enumerator 0 is always PREFIX_UNSPECIFIED.
constexpr std::string_view kZeroSuffix = "UNSPECIFIED";

std::string LowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return text;
}

}  // namespace

std::string WordOf(const google::protobuf::EnumDescriptor* type, int number) {
  const google::protobuf::EnumValueDescriptor* value = type->FindValueByNumber(number);
  if (value == nullptr || number == 0) return "unknown";
  const std::size_t prefix = type->FindValueByNumber(0)->name().size() - kZeroSuffix.size();
  return LowerCase(value->name().substr(prefix));
}

int NumberOf(const google::protobuf::EnumDescriptor* type, std::string_view word) {
  for (int i = 0; i < type->value_count(); ++i) {
    const int number = type->value(i)->number();
    if (number != 0 && WordOf(type, number) == word) return number;
  }
  return 0;
}

std::string WordsOf(const google::protobuf::EnumDescriptor* type) {
  std::vector<int> numbers;
  numbers.reserve(static_cast<std::size_t>(type->value_count()));
  for (int i = 0; i < type->value_count(); ++i) numbers.push_back(type->value(i)->number());
  std::sort(numbers.begin(), numbers.end());
  std::string words;
  for (const int number : numbers) {
    if (number == 0) continue;
    words += (words.empty() ? "" : ", ") + WordOf(type, number);
  }
  return words;
}

}  // namespace steadymap
