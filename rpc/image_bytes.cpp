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

Image ImageFromBytes(std::string_view bytes) {
  ByteReader in(bytes, "stored image");
  Image image;
  image.width = in.Get<uint32_t>();
  image.height = in.Get<uint32_t>();
  const auto values = in.GetVector<float>();
  in.ExpectEnd();
  const size_t count = size_t{image.width} * image.height;
  if (values.size() != count * 4) in.Fail("has another size than its pixels");
  for (size_t i = 0; i < count; ++i) {
    image.pixels.push_back(Rgb(values[i * 4], values[i * 4 + 1], values[i * 4 + 2]));
    image.variance.push_back(values[i * 4 + 3]);
  }
  return image;
}

}  // namespace lodestar
