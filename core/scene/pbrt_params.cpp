#include "core/scene/pbrt_params.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace lodestar {
namespace {

std::string Quoted(std::string_view text) {
  return "\"" + std::string(text) + "\"";
}

template <class Strings>
std::string List(const Strings& strings) {
  std::string out;
  for (const auto& s : strings) out += (out.empty() ? "" : ", ") + std::string(s);
  return out;
}

constexpr std::string_view kTypes[] = {"integer", "float",  "point2",  "vector2", "point3",   "vector3",  "normal",
                                       "bool",    "string", "texture", "rgb",     "spectrum", "blackbody"};

// `declared` is "type name" in quotes; passed in, since a mesh has millions of values.
void ReadValue(const Token& token, const std::string& declared, const std::string& declared_takes, PbrtParam* param) {
  if (param->type == "string" || param->type == "texture") {
    if (token.kind != Token::Kind::kString)
      FailAt(token.where(), ErrorKind::kInvalidInput, declared + " takes a quoted string, not " + token.text);
    param->strings.push_back(token.text);
  } else if (param->type == "bool") {
    if (!token.IsWord("true") && !token.IsWord("false"))
      FailAt(token.where(), ErrorKind::kInvalidInput,
             declared + " takes true or false (without quotes), not " + Quoted(token.text));
    param->bools.push_back(token.text == "true");
  } else if (param->type == "spectrum" && token.kind == Token::Kind::kString) {
    param->strings.push_back(token.text);
  } else {
    const double value = PbrtNumber(token, declared_takes);
    if (param->type == "integer" &&
        (value != std::floor(value) || std::fabs(value) > std::numeric_limits<int32_t>::max()))
      FailAt(token.where(), ErrorKind::kInvalidInput, declared + " takes 32-bit integers, not " + token.text);
    param->numbers.push_back(value);
  }
}

PbrtParam ReadDeclaration(const Token& token) {
  PbrtParam param;
  param.where = token.where();
  const size_t start = token.text.find_first_not_of(" \t");
  const size_t gap = start == std::string::npos ? start : token.text.find_first_of(" \t", start);
  const size_t name = gap == std::string::npos ? gap : token.text.find_first_not_of(" \t", gap);
  if (name == std::string::npos)
    FailAt(param.where, ErrorKind::kInvalidInput,
           "expected a parameter \"type name\", for example \"float radius\", but found " + Quoted(token.text));
  param.type = token.text.substr(start, gap - start);
  param.name = token.text.substr(name, token.text.find_last_not_of(" \t") + 1 - name);
  if (param.type == "point") param.type = "point3";
  if (param.type == "vector") param.type = "vector3";
  if (param.type == "normal3") param.type = "normal";
  if (param.type == "rgbs") param.type = "rgb";
  if (std::find(std::begin(kTypes), std::end(kTypes), param.type) == std::end(kTypes))
    FailAt(param.where, ErrorKind::kInvalidInput,
           "unknown parameter type " + Quoted(param.type) + "; pbrt-v4 has " + List(kTypes));
  return param;
}

}  // namespace

void PbrtRefusals::Refuse(const SourceLocation& where, const std::string& what) {
  if (!lenient_) FailAt(where, ErrorKind::kUnsupported, what + " (remove it, or leave it out with --lenient)");
  left_out_.push_back(where.ToString() + ": " + what);
}

double PbrtNumber(const Token& token, std::string_view what) {
  double value = 0;
  const char* first = token.text.data();
  const char* end = first + token.text.size();
  if (first != end && *first == '+') ++first;
  const auto [last, error] = std::from_chars(first, end, value);
  if (token.kind != Token::Kind::kWord || error == std::errc::invalid_argument || last != end)
    FailAt(token.where(), ErrorKind::kInvalidInput, std::string(what) + " a number, not " + Quoted(token.text));
  // Numbers too small to represent are zero; NaN, infinity and what overflows a float are refused.
  if (error == std::errc::result_out_of_range && token.text.find("e-") == std::string::npos &&
      token.text.find("E-") == std::string::npos)
    value = HUGE_VAL;
  if (!(std::fabs(value) <= std::numeric_limits<float>::max()))
    FailAt(token.where(), ErrorKind::kInvalidInput, std::string(what) + " a finite number, not " + Quoted(token.text));
  return value;
}

std::vector<PbrtParam> ReadPbrtParams(Tokenizer& in) {
  std::vector<PbrtParam> params;
  while (in.Peek() && in.Peek()->kind == Token::Kind::kString) {
    PbrtParam param = ReadDeclaration(*in.Next());
    const auto twin =
        std::find_if(params.begin(), params.end(), [&](const PbrtParam& p) { return p.name == param.name; });
    if (twin != params.end())
      FailAt(param.where, ErrorKind::kInvalidInput,
             "parameter " + Quoted(param.name) + " is given twice; first at " + twin->where.ToString());
    const auto first = in.Next();
    const std::string declared = Quoted(param.type + " " + param.name), declared_takes = declared + " takes";
    if (!first)
      FailAt(in.Here(), ErrorKind::kInvalidInput, "the file ends where the value of " + declared + " should be");
    if (first->kind == Token::Kind::kClose)
      FailAt(first->where(), ErrorKind::kInvalidInput, "expected the value of " + declared + ", not ]");
    if (first->kind != Token::Kind::kOpen) {
      ReadValue(*first, declared, declared_takes, &param);
    } else {
      while (true) {
        const auto token = in.Next();
        if (!token) FailAt(first->where(), ErrorKind::kInvalidInput, "this [ of " + declared + " is never closed");
        if (token->kind == Token::Kind::kClose) break;
        if (token->kind == Token::Kind::kOpen)
          FailAt(token->where(), ErrorKind::kInvalidInput, "a [ inside the values of " + declared);
        ReadValue(*token, declared, declared_takes, &param);
      }
    }
    params.push_back(std::move(param));
  }
  return params;
}

PbrtParams::PbrtParams(std::string label, SourceLocation where, std::vector<PbrtParam> params,
                       const std::vector<PbrtParam>& inherited, PbrtRefusals* refusals)
    : label_(std::move(label)), where_(std::move(where)), params_(std::move(params)), refusals_(refusals) {
  const size_t own = params_.size();
  for (const PbrtParam& param : inherited) {
    const auto same = [&](const PbrtParam& p) { return p.name == param.name; };
    if (std::none_of(params_.begin(), params_.begin() + static_cast<std::ptrdiff_t>(own), same)) {
      params_.push_back(param);
      params_.back().inherited = true;
    }
  }
}

void PbrtParams::Fail(const PbrtParam& param, const std::string& why) const {
  FailAt(param.where, ErrorKind::kInvalidInput, "\"" + param.type + " " + param.name + "\" of " + label_ + " " + why);
}

PbrtParam* PbrtParams::Known(std::string_view name) {
  if (std::find(known_.begin(), known_.end(), name) == known_.end()) known_.emplace_back(name);
  for (PbrtParam& param : params_) {
    if (param.name != name) continue;
    param.used = true;
    return &param;
  }
  return nullptr;
}

const PbrtParam* PbrtParams::Find(std::string_view name, std::initializer_list<std::string_view> types) {
  const PbrtParam* param = Known(name);
  if (param && std::find(types.begin(), types.end(), param->type) == types.end()) {
    std::string expected;
    for (std::string_view type : types)
      expected += (expected.empty() ? "" : " or ") + Quoted(std::string(type) + " " + std::string(name));
    Fail(*param, "has the wrong type: expected " + expected);
  }
  return param;
}

const PbrtParam* PbrtParams::One(std::string_view name, std::string_view type) {
  const PbrtParam* param = Find(name, {type});
  if (!param) return nullptr;
  const size_t count = param->numbers.size() + param->strings.size() + param->bools.size();
  if (count != 1) Fail(*param, "takes one value, not " + std::to_string(count));
  return param;
}

std::optional<float> PbrtParams::FindFloat(std::string_view name) {
  const PbrtParam* param = One(name, "float");
  return param ? std::optional<float>(static_cast<float>(param->numbers[0])) : std::nullopt;
}
float PbrtParams::Float(std::string_view name, float otherwise) {
  return FindFloat(name).value_or(otherwise);
}
float PbrtParams::PositiveFloat(std::string_view name, float otherwise) {
  const float value = Float(name, otherwise);
  if (!(value > 0)) Fail(*Known(name), "must be greater than 0");
  return value;
}
float PbrtParams::NonNegativeFloat(std::string_view name, float otherwise) {
  const float value = Float(name, otherwise);
  if (!(value >= 0)) Fail(*Known(name), "must not be negative");
  return value;
}
int PbrtParams::Int(std::string_view name, int otherwise) {
  const PbrtParam* param = One(name, "integer");
  return param ? static_cast<int>(param->numbers[0]) : otherwise;
}
bool PbrtParams::Bool(std::string_view name, bool otherwise) {
  const PbrtParam* param = One(name, "bool");
  return param ? param->bools[0] : otherwise;
}
std::optional<std::string> PbrtParams::FindString(std::string_view name) {
  const PbrtParam* param = One(name, "string");
  return param ? std::optional<std::string>(param->strings[0]) : std::nullopt;
}

Vec3 PbrtParams::Point(std::string_view name, Vec3 otherwise) {
  const std::vector<Vec3> points = Vec3s(name, "point3");
  if (points.size() > 1) Fail(*Known(name), "takes one point, not " + std::to_string(points.size()));
  return points.empty() ? otherwise : points[0];
}

std::vector<float> PbrtParams::Floats(std::string_view name) {
  const PbrtParam* param = Find(name, {"float"});
  return param ? std::vector<float>(param->numbers.begin(), param->numbers.end()) : std::vector<float>();
}

std::vector<uint32_t> PbrtParams::Indices(std::string_view name, size_t limit) {
  std::vector<uint32_t> indices;
  const PbrtParam* param = Find(name, {"integer"});
  if (!param) return indices;
  indices.reserve(param->numbers.size());
  for (double index : param->numbers) {
    if (!(index >= 0 && index < static_cast<double>(limit)))
      Fail(*param, "has the index " + std::to_string(static_cast<int64_t>(index)) + ", out of range: there are " +
                       std::to_string(limit) + " vertices");
    indices.push_back(static_cast<uint32_t>(index));
  }
  return indices;
}

std::vector<Vec3> PbrtParams::Vec3s(std::string_view name, std::string_view type) {
  const PbrtParam* param = Find(name, {type});
  if (!param) return {};
  if (param->numbers.empty() || param->numbers.size() % 3 != 0)
    Fail(*param, "takes three numbers a value, not " + std::to_string(param->numbers.size()) + " in all");
  std::vector<Vec3> values(param->numbers.size() / 3);
  for (size_t i = 0; i < param->numbers.size(); ++i)
    values[i / 3][static_cast<int>(i % 3)] = static_cast<float>(param->numbers[i]);
  return values;
}

std::vector<Vec2> PbrtParams::Vec2s(std::string_view name, std::string_view type) {
  const PbrtParam* param = Find(name, {type});
  if (!param) return {};
  if (param->numbers.size() % 2 != 0)
    Fail(*param, "takes two numbers a value, not " + std::to_string(param->numbers.size()) + " in all");
  std::vector<Vec2> values;
  values.reserve(param->numbers.size() / 2);
  for (size_t i = 0; i < param->numbers.size(); i += 2)
    values.push_back({static_cast<float>(param->numbers[i]), static_cast<float>(param->numbers[i + 1])});
  return values;
}

void PbrtParams::Accept(std::initializer_list<std::string_view> names) {
  for (std::string_view name : names) Known(name);
}

void PbrtParams::Refuse(std::initializer_list<std::string_view> names, const std::string& why) {
  for (std::string_view name : names)
    if (const PbrtParam* param = Known(name))
      refusals_->Refuse(param->where,
                        "\"" + param->type + " " + param->name + "\" of " + label_ + " is not supported: " + why);
}

void PbrtParams::RefuseUnless(std::string_view name, std::initializer_list<float> value, const std::string& why) {
  const PbrtParam* param = Find(name, {"float", "integer"});
  if (!param) return;
  const std::vector<float> values(param->numbers.begin(), param->numbers.end());
  if (!std::equal(values.begin(), values.end(), value.begin(), value.end())) Refuse({name}, why);
}

void PbrtParams::RefuseUnless(std::string_view name, bool value, const std::string& why) {
  if (Bool(name, value) != value) Refuse({name}, why);
}

void PbrtParams::Finish() {
  for (const PbrtParam& param : params_) {
    if (param.used || param.inherited) continue;
    std::sort(known_.begin(), known_.end());
    Fail(param, known_.empty() ? "is not used: it takes no parameters" : "is not used; it takes: " + List(known_));
  }
}

}  // namespace lodestar
