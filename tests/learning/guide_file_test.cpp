#include "core/learning/guide_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "core/base/error.h"
#include "core/base/sealed_bytes.h"
#include "core/math/sampler.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

GuideFile FileOf(Bytes state) {
  GuideFile file;
  file.job = test::SyntheticJob("sdtree", 8);
  file.survey = test::SyntheticSurvey();
  file.iterations = 3;
  file.state = std::move(state);
  return file;
}

TEST(GuideFile, StatesOfAnySizeTravel) {
  uint64_t random = 1;
  for (const size_t size : {size_t{0}, size_t{1}, size_t{1} << 22, (size_t{9} << 20) + 5}) {
    Bytes state(size, 'x');
    // Half of it noise, which does not compress.
    for (size_t i = 0; i < size / 2; ++i) state[i] = static_cast<char>(random = Mix64(random));
    const Bytes bytes = FileOf(state).Serialize();
    const GuideFile back = GuideFile::Parse(bytes, "a state");
    EXPECT_TRUE(back.state == state) << size;
    EXPECT_EQ(back.iterations, 3u);
    EXPECT_TRUE(back.Serialize() == bytes) << size;
  }
}

long PeakKilobytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

// A file with a right checksum around a frame that announces 8 GiB and holds 128 KiB of one letter, or nothing.
TEST(GuideFile, AnAnnouncedSizeTakesNoMemory) {
  const auto file = [](std::string_view blocks) {
    ByteWriter frame;
    frame.Put<uint32_t>(0xfd2fb528);  // zstd's
    frame.Put<uint8_t>(0xc0);         // the size has eight bytes
    frame.Put<uint8_t>(0x48);         // a window of half a MiB
    frame.Put<uint64_t>(uint64_t{1} << 33);
    frame.PutRaw(blocks);
    ByteWriter out = OpenDocument(DocumentMagic("LGDE"), 1);
    out.PutString(frame.bytes());
    return Seal(std::move(out));
  };
  const long before = PeakKilobytes();
  const std::string_view letters("\x03\x00\x10x", 4);  // the last block: 2^17 times one byte
  for (const std::string_view blocks : {letters, std::string_view()}) {
    try {
      GuideFile::Parse(file(blocks), "a state");
      ADD_FAILURE() << "was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kCorrupt);
      EXPECT_NE(std::string(error.what()).find("does not decompress"), std::string::npos) << error.what();
    }
  }
  EXPECT_LT(PeakKilobytes() - before, 1 << 20);
}

}  // namespace
}  // namespace lodestar
