#include "core/scene/ply.h"

#include <zlib.h>

#include <cstring>

#include "tests/scene/pbrt_testing.h"

namespace lodestar {
namespace {

enum class Format { kAscii, kLittle, kBig };

// Writes PLY data; numbers go in as they are declared.
class PlyText {
 public:
  explicit PlyText(Format format) : format_(format) {}
  template <class T>
  PlyText& Put(T value) {
    if (format_ == Format::kAscii) {
      bytes_ += std::to_string(value) + " ";
      return *this;
    }
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (format_ == Format::kBig) std::reverse(raw, raw + sizeof(T));
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  Format format_;
  std::string bytes_;
};

// A quad and a triangle, with everything: normals, uvs, other properties and elements to skip.
std::string FullMesh(Format format) {
  const char* name = format == Format::kAscii    ? "ascii"
                     : format == Format::kLittle ? "binary_little_endian"
                                                 : "binary_big_endian";
  const std::string header =
      std::string("ply\nformat ") + name +
      " 1.0\ncomment made by a test\nobj_info nothing\nelement other 2\nproperty list uchar short odd\nproperty double "
      "d\n"
      "element vertex 5\nproperty float x\nproperty double y\nproperty float z\nproperty uchar red\nproperty list "
      "uchar int extra\n"
      "property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n"
      "element face 2\nproperty char flag\nproperty list uint8 uint vertex_indices\nproperty int "
      "face_indices\nend_header\n";
  PlyText out(format);
  out.Put<uint8_t>(2).Put<int16_t>(-7).Put<int16_t>(300).Put<double>(0.5);
  out.Put<uint8_t>(0).Put<double>(-1.5);
  for (int i = 0; i < 5; ++i) {
    out.Put<float>(float(i)).Put<double>(i * 0.5).Put<float>(-float(i)).Put<uint8_t>(200).Put<uint8_t>(1).Put<int32_t>(
        -70000);
    out.Put<float>(0).Put<float>(0).Put<float>(1).Put<float>(i * 0.25f).Put<float>(1 - i * 0.25f);
  }
  out.Put<int8_t>(-1).Put<uint8_t>(4).Put<uint32_t>(0).Put<uint32_t>(1).Put<uint32_t>(2).Put<uint32_t>(3).Put<int32_t>(
      9);
  out.Put<int8_t>(-1).Put<uint8_t>(3).Put<uint32_t>(4).Put<uint32_t>(3).Put<uint32_t>(2).Put<int32_t>(9);
  return header + out.bytes();
}

void ExpectFullMesh(const TriangleMesh& mesh) {
  ASSERT_EQ(mesh.positions.size(), 5u);
  EXPECT_EQ(mesh.positions[3], (Vec3{3, 1.5f, -3}));
  ASSERT_EQ(mesh.normals.size(), 5u);
  EXPECT_EQ(mesh.normals[4], (Vec3{0, 0, 1}));
  ASSERT_EQ(mesh.uvs.size(), 5u);
  EXPECT_EQ(mesh.uvs[1], (Vec2{0.25f, 0.75f}));
  const std::vector<std::array<uint32_t, 3>> triangles = {
      {0, 1, 2}, {0, 2, 3}, {4, 3, 2}};  // the quad is split along 0-2
  EXPECT_EQ(mesh.triangles, triangles);
}

TEST(Ply, ReadsEveryFormatAlike) {
  TemporaryFolder folder;
  for (Format format : {Format::kAscii, Format::kLittle, Format::kBig}) {
    const std::string bytes = FullMesh(format);
    ExpectFullMesh(ReadPly(folder.Write("m.ply", bytes)));
    const auto packed = folder.path() / "m.ply.gz";
    gzFile gz = gzopen(packed.c_str(), "wb");
    gzwrite(gz, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(gz);
    ExpectFullMesh(ReadPly(packed));
  }
}

std::string Ascii(const std::string& vertices, const std::string& faces, int vertex_count = 3, int face_count = 1) {
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertex_count) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(face_count) +
         "\nproperty list uchar int vertex_index\nend_header\n" + vertices + "\n" + faces + "\n";
}

TEST(Ply, ReadsMinimalFilesWithCarriageReturns) {
  TemporaryFolder folder;
  std::string text = Ascii("0 0 0 +1 0 0\n0 1e0 0", "3 0 1 2");
  for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.insert(at, "\r");
  const TriangleMesh mesh = ReadPly(folder.Write("m.ply", text));
  EXPECT_EQ(mesh.positions.size(), 3u);
  EXPECT_TRUE(mesh.normals.empty());
  EXPECT_TRUE(mesh.uvs.empty());
}

struct BadPly {
  std::string bytes;
  ErrorKind kind;
  std::string fragment;
};
void ExpectBad(const BadPly& c) {
  SCOPED_TRACE(c.bytes.substr(0, 300));
  try {
    ParsePly(c.bytes, "bad.ply");
    ADD_FAILURE() << "was accepted";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind("bad.ply:", 0), 0u) << message;
    EXPECT_NE(message.find(c.fragment), std::string::npos) << message;
    EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(c.kind)) << message;
  }
}

TEST(Ply, NamesTheElementThatIsWrong) {
  const std::string ok = "0 0 0 1 0 0 0 1 0";
  const BadPly cases[] = {
      {Ascii("0 0 0 nan 0 0 0 1 0", "3 0 1 2"), kBad, "vertex 1: \"x\" is not finite"},
      {Ascii("0 0 0 1 0 inf 0 1 0", "3 0 1 2"), kBad, "vertex 1: \"z\" is not finite"},
      {Ascii("0 0 0 1 0 zero 0 1 0", "3 0 1 2"), kBad, "vertex 1: \"zero\" is not a number"},
      {Ascii(ok, "3 0 1 3"), kBad, "face 0: vertex index 3 is out of range (the file has 3 vertices)"},
      {Ascii(ok, "3 0 1 2 3 0 -1 2", 3, 2), kBad, "face 1: vertex index -1"},
      {Ascii(ok, "3 0 1 1.5"), kBad, "face 0: \"1.5\" is not an integer"},
      {Ascii(ok, "2 0 1"), kBad, "face 0: has 2 vertices"},
      {Ascii(ok, "-3 0 1 2"), kBad, "face 0: list \"vertex_index\" has a negative length"},
      {Ascii(ok, "5 0 1 2 0 1"), kNo, "face 0: is a polygon of 5 vertices"},
      {Ascii(ok, "3 0 1"), ErrorKind::kCorrupt, "face 0: the file is truncated"},
      {Ascii(ok, "3 0 1 2", 3, 2000000000), ErrorKind::kCorrupt, "promises 2000000000 elements \"face\""},
      {Ascii(ok, "", 3, 0), kBad, "has no faces"},
      {Ascii("", "", 0, 0), kBad, "has no vertices"},
  };
  for (const BadPly& c : cases) ExpectBad(c);
  std::string binary = FullMesh(Format::kLittle);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  // The third vertex's x: 22 bytes of the first element, 42 a vertex.
  std::memcpy(binary.data() + binary.find("end_header\n") + 11 + 22 + 2 * 42, &nan, 4);
  ExpectBad({binary, kBad, "vertex 2: \"x\" is not finite"});
  ExpectBad({FullMesh(Format::kBig).substr(0, FullMesh(Format::kBig).size() - 1), ErrorKind::kCorrupt,
             "face 1: the file is truncated"});
}

TEST(Ply, RefusesMalformedHeaders) {
  const std::string head = "ply\nformat ascii 1.0\n";
  const BadPly cases[] = {
      {"", kBad, ":1: PLY header: ends before"},
      {"solid cube\nend_header\n", kBad, ":1: PLY header: does not start with \"ply\""},
      {"ply\nend_header\n", kBad, "no \"format\""},
      {"ply\nformat ascii 2.0\nend_header\n", kBad, ":2: PLY header: expected \"format TYPE 1.0\""},
      {"ply\nformat binary 1.0\nend_header\n", kBad, "unknown format \"binary\""},
      {head + "element vertex\nend_header\n", kBad, ":3: PLY header: expected \"element NAME COUNT\""},
      {head + "element vertex many\nend_header\n", kBad, "\"many\" is not a count"},
      {head + "element vertex -3\nend_header\n", kBad, "\"-3\" is not a count"},
      {head + "property float x\nend_header\n", kBad, "a property before the first element"},
      {head + "element vertex 3\nproperty half x\nend_header\n", kBad, ":4: PLY header: unknown type \"half\""},
      {head + "element vertex 3\nproperty float\nend_header\n", kBad, "expected \"property TYPE NAME\""},
      {head + "element vertex 3\nproperty list float int x\nend_header\n", kBad, "must be an integer type"},
      {head + "element vertex 3\nproperty float x\nproperty float x\nend_header\n", kBad, "\"x\" is there twice"},
      {head + "vertices 3\nend_header\n", kBad, "unknown keyword \"vertices\""},
      {head + "element vertex 3\nproperty float x\n", kBad, "ends before \"end_header\""},
      {head + "element vertex 1\nproperty float x\nproperty float y\nend_header\n1 1\n", kBad,
       "vertices have no x, y and z"},
      {head + "element vertex 1\nproperty float x\nproperty float y\nproperty list uchar float z\nend_header\n1 1 0\n",
       kBad, "a list for \"z\""},
      {head + "element vertex 1\nproperty float x\nproperty float y\nproperty float z\nproperty float "
              "nx\nend_header\n1 1 1 1\n",
       kBad, "some of nx, ny and nz"},
      {head + "element vertex 1\nproperty float x\nproperty float y\nproperty float z\nproperty float u\nend_header\n1 "
              "1 1 1\n",
       kBad, "one of u and v"},
      {head + "element face 1\nproperty float area\nend_header\n1\n", kBad, "no integer list \"vertex_indices\""},
      {head + "element face 1\nproperty list uchar float vertex_indices\nend_header\n3 0 1 2\n", kBad,
       "no integer list"},
      {Ascii("0 0 0 1 0 0 0 1 0", "3 0 1 2")
           .replace(0, 21,
                    "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n"),
       kBad, "two elements \"vertex\""},
  };
  for (const BadPly& c : cases) ExpectBad(c);
}

TEST(Ply, EveryPrefixIsAnErrorAndNotACrash) {
  TemporaryFolder folder;
  for (Format format : {Format::kAscii, Format::kLittle, Format::kBig}) {
    const std::string bytes = FullMesh(format);
    // The last ascii number may lose its trailing space, or its last digits, and still be one.
    const size_t end = bytes.size() - (format == Format::kAscii ? 2 : 0);
    for (size_t size = 0; size < end; ++size) EXPECT_THROW(ParsePly(bytes.substr(0, size), "p.ply"), Error) << size;
  }
  EXPECT_THROW(ReadPly(folder.path() / "absent.ply"), Error);
}

}  // namespace
}  // namespace lodestar
