#include "core/learning/method_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/check.h"

namespace lodestar {

bool ParseNumber(std::string_view text, double* value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(*value);
}

MethodOptions::MethodOptions(std::string method, std::span<const OptionHelp> known,
                             const std::map<std::string, std::string>& given)
    : method_(std::move(method)), known_(known), given_(given) {
  for (const auto& [name, value] : given) {
    if (std::any_of(known.begin(), known.end(), [&](const OptionHelp& o) { return o.name == name; })) continue;
    std::string names;
    for (const OptionHelp& o : known) names += (names.empty() ? "" : ", ") + o.name;
    throw Error(ErrorKind::kInvalidInput, "method '" + method_ + "' has no option '" + name + "'; it has: " + names);
  }
}

const OptionHelp& MethodOptions::Help(std::string_view name) const {
  const auto found = std::find_if(known_.begin(), known_.end(), [&](const OptionHelp& o) { return o.name == name; });
  LODESTAR_CHECK(found != known_.end());
  return *found;
}

const std::string& MethodOptions::Text(std::string_view name) const {
  const auto found = given_.find(std::string(name));
  return found != given_.end() ? found->second : Help(name).default_value;
}

double MethodOptions::Number(std::string_view name, double low, double high) const {
  double value;
  if (!ParseNumber(Text(name), &value) || value < low || value > high) Refuse(name);
  return value;
}

int MethodOptions::Integer(std::string_view name, int low, int high) const {
  const double value = Number(name, low, high);
  if (value != std::floor(value)) Refuse(name);
  return static_cast<int>(value);
}

void MethodOptions::Refuse(std::string_view name) const {
  throw Error(ErrorKind::kInvalidInput, "option '" + std::string(name) + "' of method '" + method_ + "' cannot be '" +
                                            Text(name) + "'; it takes " + Help(name).values);
}

}  // namespace lodestar
