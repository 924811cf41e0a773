// Reading a method's options: texts by name, checked against the method's documentation, so that what is documented and
// what is read cannot drift apart.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/learning/method.h"

namespace lodestar {

class MethodOptions {
 public:
  // Throws Error(kInvalidInput) for a name that is not in `known`, listing those there are.
  MethodOptions(std::string method, std::span<const OptionHelp> known, const std::map<std::string, std::string>& given);

  bool Has(std::string_view name) const { return given_.contains(std::string(name)); }
  // What was given, else the documented default.
  const std::string& Text(std::string_view name) const;
  // These throw Error(kInvalidInput) with the documented values where the text is none of them.
  double Number(std::string_view name, double low, double high) const;
  int Integer(std::string_view name, int low, int high) const;
  template <class E>
  E Choice(std::string_view name, const std::vector<std::pair<std::string_view, E>>& choices) const {
    for (const auto& [text, value] : choices) {
      if (Text(name) == text) return value;
    }
    Refuse(name);
  }
  // The same for options whose default another option decides: what was given, else `otherwise`, which is not checked.
  double NumberOr(std::string_view name, double otherwise, double low, double high) const {
    return Has(name) ? Number(name, low, high) : otherwise;
  }
  template <class E>
  E ChoiceOr(std::string_view name, E otherwise, const std::vector<std::pair<std::string_view, E>>& choices) const {
    return Has(name) ? Choice<E>(name, choices) : otherwise;
  }
  [[noreturn]] void Refuse(std::string_view name) const;

 private:
  const OptionHelp& Help(std::string_view name) const;

  std::string method_;
  std::span<const OptionHelp> known_;
  std::map<std::string, std::string> given_;
};

// A number in plain decimal notation, independent of the locale; false for anything else, and for what is not finite.
bool ParseNumber(std::string_view text, double* value);

}  // namespace lodestar
