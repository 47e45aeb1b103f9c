#include "octavo/core/made_by.h"

#include "octavo/core/json_reader.h"

namespace octavo {

std::optional<double> MadeBy::number(std::string_view name) const {
  const std::string_view json = settings_.json_of(name);
  if (json.empty()) return std::nullopt;
  JsonReader in(json);
  in.next();
  return in.number();
}

}  // namespace octavo
