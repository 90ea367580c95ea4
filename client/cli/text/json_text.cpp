#include "client/cli/text/json_text.h"

namespace steadymap {
namespace {

constexpr int kOneLine = -1;

std::string Text(const Json& document, int indentation) {
  return document.dump(indentation, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace) +
         '\n';
}

}  // namespace

std::string IndentedJson(const Json& document) { return Text(document, 2); }

std::string JsonLine(const Json& document) { return Text(document, kOneLine); }

Json VectorJson(double x, double y, double z) { return Json::array({x, y, z}); }

}  // namespace steadymap
