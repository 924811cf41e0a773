#include "core/base/sealed_bytes.h"

#include <gtest/gtest.h>

#include <string>

namespace lodestar {
namespace {

TEST(SealedBytes, AnotherVersionIsNamed) {
  constexpr uint32_t kMagic = DocumentMagic("TEST");
  ByteWriter out = OpenDocument(kMagic, 2);
  out.PutString("content");
  const Bytes bytes = Seal(std::move(out));
  EXPECT_EQ(OpenSealed(bytes, kMagic, 2, "paper").size(), 8 + 7u);
  try {
    OpenSealed(bytes, kMagic, 1, "paper");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kConflict);
    EXPECT_NE(std::string(error.what()).find("paper has format version 2, this program reads version 1"),
              std::string::npos)
        << error.what();
  }
  EXPECT_THROW(OpenSealed(bytes, DocumentMagic("ELSE"), 2, "paper"), Error);
  EXPECT_THROW(OpenSealed("", kMagic, 2, "paper"), Error);
}

}  // namespace
}  // namespace lodestar
