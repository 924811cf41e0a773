// The parameter list of one directive: "type name" value pairs, fetched by name with their type checked. What no one
// fetched is an error when the list is finished, so that nothing in a file is silently ignored.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/description.h"
#include "core/scene/pbrt_tokenizer.h"

namespace lodestar {

// What to do with something valid in pbrt-v4 that is not supported here: throw Error(kUnsupported), or (lenient) write
// it down.
class PbrtRefusals {
 public:
  explicit PbrtRefusals(bool lenient) : lenient_(lenient) {}
  void Refuse(const SourceLocation& where, const std::string& what);
  std::vector<std::string> Take() { return std::move(left_out_); }

 private:
  bool lenient_;
  std::vector<std::string> left_out_;
};

struct PbrtParam {
  std::string type, name;  // pbrt's aliases resolved: point -> point3, vector -> vector3, normal3 -> normal
  SourceLocation where;
  std::vector<double> numbers;  // integers too
  std::vector<std::string> strings;
  std::vector<bool> bools;
  bool inherited = false;  // from an Attribute directive: may go unused
  bool used = false;
};

// Reads "type name" value pairs up to the next token that is not a string.
std::vector<PbrtParam> ReadPbrtParams(Tokenizer& in);
// The number in a token, or an error that says `what` was expected.
double PbrtNumber(const Token& token, std::string_view what);

class PbrtParams {
 public:
  // `label` names the directive in messages: Shape "sphere". Inherited ones hold where the list has none of that name.
  PbrtParams(std::string label, SourceLocation where, std::vector<PbrtParam> params,
             const std::vector<PbrtParam>& inherited, PbrtRefusals* refusals);

  const std::string& label() const { return label_; }
  const SourceLocation& where() const { return where_; }
  PbrtRefusals& refusals() const { return *refusals_; }

  // The parameter of that name, or null; an error where its type is none of `types`.
  const PbrtParam* Find(std::string_view name, std::initializer_list<std::string_view> types);

  float Float(std::string_view name, float otherwise);
  float PositiveFloat(std::string_view name, float otherwise);     // > 0
  float NonNegativeFloat(std::string_view name, float otherwise);  // >= 0
  std::optional<float> FindFloat(std::string_view name);
  int Int(std::string_view name, int otherwise);
  bool Bool(std::string_view name, bool otherwise);
  std::optional<std::string> FindString(std::string_view name);
  std::string String(std::string_view name, const std::string& otherwise) {
    return FindString(name).value_or(otherwise);
  }
  Vec3 Point(std::string_view name, Vec3 otherwise);
  // Empty where absent.
  std::vector<float> Floats(std::string_view name);
  std::vector<uint32_t> Indices(std::string_view name, size_t limit);  // each in [0, limit)
  std::vector<Vec3> Vec3s(std::string_view name, std::string_view type);
  std::vector<Vec2> Vec2s(std::string_view name, std::string_view type);

  // Known parameters without an effect on the image here.
  void Accept(std::initializer_list<std::string_view> names);
  // Parameters of pbrt-v4 that are not supported.
  void Refuse(std::initializer_list<std::string_view> names, const std::string& why);
  // The same, where the value differs from the only one supported.
  void RefuseUnless(std::string_view name, std::initializer_list<float> value, const std::string& why);
  void RefuseUnless(std::string_view name, bool value, const std::string& why);
  // Throws for a parameter that was never asked for.
  void Finish();

  [[noreturn]] void Fail(const PbrtParam& param, const std::string& why) const;

 private:
  PbrtParam* Known(std::string_view name);
  const PbrtParam* One(std::string_view name, std::string_view type);

  std::string label_;
  SourceLocation where_;
  std::vector<PbrtParam> params_;
  std::vector<std::string> known_;  // every name asked for: what the directive takes
  PbrtRefusals* refusals_;
};

}  // namespace lodestar
