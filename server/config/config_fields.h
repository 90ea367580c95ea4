#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "server/config/server_config.h"

namespace steadymap {

/// A field as a person sees it.
struct FieldName {
  std::string_view name;           ///< The key in the file; carries the unit.
  std::string_view documentation;  ///< One or two sentences, the same as beside the struct's field.
};

/// Values that an integer field may take, both ends included.
struct IntegerRange {
  std::int64_t min = 0;
  std::int64_t max = 0;
};

/// Something that walks over all fields of a configuration: loading, validation, printing. It may
/// change what it is given.
class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;

  /// The fields that follow stand in the table `name`; before the first call, in the root.
  virtual void Section(std::string_view name, std::string_view documentation) = 0;
  virtual void Text(const FieldName& field, std::string* value) = 0;
  virtual void Flag(const FieldName& field, bool* value) = 0;
  virtual void Integer(const FieldName& field, const IntegerRange& range, std::int64_t* value) = 0;

  /// `*value` is an index into `choices`.
  virtual void Choice(const FieldName& field,
                      std::span<const std::string_view> choices,
                      std::size_t* value) = 0;
};

/// The one list of all fields: calls `visitor` for each in the order of the file.
void VisitFields(ServerConfig* config, FieldVisitor* visitor);

}  // namespace steadymap
