// Shared by the parser's tests: parsing of a text, tables of what is refused.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/scene/pbrt_parser.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {

// The folder that relative names in texts resolve against; holds image.png, mesh.ply and light.spd.
inline const std::filesystem::path& Folder() {
  static const TemporaryFolder folder;
  static const bool written = [] {
    folder.Write("image.png", "not read by the parser");
    folder.Write("mesh.ply", "not read by the parser");
    folder.Write("light.spd", "# wavelength value\n400 1\n700 1\n");
    folder.Write("broken.spd", "400 1 500\n");
    return true;
  }();
  (void)written;
  return folder.path();
}

inline SceneDescription Parse(const std::string& text, bool lenient = false) {
  return ParsePbrtText(text, "s.pbrt", Folder(), {.lenient = lenient});
}
// The text stands in line 2, after WorldBegin.
inline SceneDescription ParseWorld(const std::string& text, bool lenient = false) {
  return Parse("WorldBegin\n" + text, lenient);
}

// A text that must be refused: the kind, where (line:column), and a fragment of the message.
struct Refused {
  const char* text;
  ErrorKind kind;
  const char* where;
  const char* fragment;
};
inline void ExpectRefused(const Refused& c, bool in_world) {
  SCOPED_TRACE(c.text);
  try {
    in_world ? ParseWorld(c.text) : Parse(c.text);
    ADD_FAILURE() << "was accepted";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind(std::string("s.pbrt:") + c.where + ": ", 0), 0u) << message;
    EXPECT_NE(message.find(c.fragment), std::string::npos) << message;
    EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(c.kind)) << message;
  }
  // What is valid but unsupported is left out, and listed with its place, on request.
  if (c.kind == ErrorKind::kUnsupported) {
    const SceneDescription scene =
        in_world ? ParseWorld(c.text, true) : Parse(std::string(c.text) + "\nWorldBegin", true);
    ASSERT_FALSE(scene.left_out.empty());
    EXPECT_EQ(scene.left_out[0].rfind(std::string("s.pbrt:") + c.where + ": ", 0), 0u) << scene.left_out[0];
  }
}

constexpr ErrorKind kBad = ErrorKind::kInvalidInput, kNo = ErrorKind::kUnsupported, kMissing = ErrorKind::kNotFound;

template <class T, class Variant>
const T& Get(const Variant& variant) {
  const T* value = std::get_if<T>(&variant);
  if (!value) throw std::runtime_error("the parser made something of another kind");
  return *value;
}
inline void ExpectRgb(Rgb actual, Rgb expected, float tolerance = 1e-6f) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], tolerance) << "component " << c;
}

}  // namespace lodestar
