#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "server/config/server_config.h"

namespace steadymap {

/// Name and documentation of a field.
struct FieldName {
  std::string_view name;           ///< The key in the file; includes the unit.
  std::string_view documentation;  ///< Short form of the field's docstring.
};

/// Valid values of an integer field, both ends included.
struct IntegerRange {
  std::int64_t min = 0;
  std::int64_t max = 0;
};

/// A visitor of all fields of a configuration, for loading, validation and printing. May change the
/// values.
class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;

  /// Begins the table `name`, which contains the following fields. Fields before the first call are
  /// in the root table.
  virtual void Section(std::string_view name, std::string_view documentation) = 0;
  virtual void Text(const FieldName& field, std::string* value) = 0;
  virtual void Flag(const FieldName& field, bool* value) = 0;
  virtual void Integer(const FieldName& field, const IntegerRange& range, std::int64_t* value) = 0;

  /// `*value` is an index into `choices`.
  virtual void Choice(const FieldName& field,
                      std::span<const std::string_view> choices,
                      std::size_t* value) = 0;
};

/// Calls `visitor` for each field, in the order of the file. The only list of all fields.
void VisitFields(ServerConfig* config, FieldVisitor* visitor);

}  // namespace steadymap
