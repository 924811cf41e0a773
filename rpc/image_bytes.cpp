#include "rpc/image_bytes.h"

namespace lodestar {

Bytes ImageToBytes(const Image& image) {
  ByteWriter out;
  out.Put(image.width);
  out.Put(image.height);
  std::vector<float> values;
  values.reserve(image.pixels.size() * 4);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const Rgb& p = image.pixels[i];
    values.insert(values.end(), {p.r, p.g, p.b, image.variance.empty() ? 0 : image.variance[i]});
  }
  out.PutVector(values);
  return out.Take();
}

uint64_t ImageBytesSize(uint32_t width, uint32_t height) {
  return 2 * sizeof(uint32_t) + sizeof(uint64_t) + uint64_t{16} * width * height;
}

Image ImageFromBytes(std::string_view bytes) {
  ByteReader in(bytes, "image");
  Image image;
  image.width = in.Get<uint32_t>();
  image.height = in.Get<uint32_t>();
  const auto values = in.GetVector<float>();
  in.ExpectEnd();
  // Divided, not multiplied: the sizes come from whoever wrote the bytes.
  const size_t count = size_t{image.width} * image.height;
  if (values.size() % 4 != 0 || values.size() / 4 != count) in.Fail("has another size than its pixels");
  image.pixels.reserve(count);
  image.variance.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    image.pixels.push_back(Rgb(values[i * 4], values[i * 4 + 1], values[i * 4 + 2]));
    image.variance.push_back(values[i * 4 + 3]);
  }
  return image;
}

}  // namespace lodestar
