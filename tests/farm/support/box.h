// A box with an area light in its ceiling and two blocks: our own, and small enough for a test to render in a second.
#pragma once

namespace lodestar {

inline constexpr const char* kBoxScene = R"(
LookAt 0 1 3.4  0 1 0  0 1 0
Camera "perspective" "float fov" [ 40 ]
Film "rgb" "integer xresolution" [ 64 ] "integer yresolution" [ 48 ]
PixelFilter "box" "float xradius" [ 0.5 ] "float yradius" [ 0.5 ]
Sampler "independent" "integer pixelsamples" [ 8 ]
Integrator "path" "integer maxdepth" [ 6 ]
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [ 12 11 9 ]
  Material "diffuse" "rgb reflectance" [ 0 0 0 ]
  Shape "trianglemesh" "point3 P" [ -0.3 1.98 -0.3  0.3 1.98 -0.3  0.3 1.98 0.3  -0.3 1.98 0.3 ] "integer indices" [ 0 1 2 0 2 3 ]
AttributeEnd
Material "diffuse" "rgb reflectance" [ 0.7 0.7 0.7 ]
Shape "trianglemesh" "point3 P" [ -1 0 -1  1 0 -1  1 0 1  -1 0 1 ] "integer indices" [ 0 1 2 0 2 3 ]
Shape "trianglemesh" "point3 P" [ -1 2 -1  1 2 -1  1 2 1  -1 2 1 ] "integer indices" [ 0 1 2 0 2 3 ]
Shape "trianglemesh" "point3 P" [ -1 0 -1  1 0 -1  1 2 -1  -1 2 -1 ] "integer indices" [ 0 1 2 0 2 3 ]
# The same wall again in another colour: which of two coplanar surfaces is seen must not depend on anything.
Material "diffuse" "rgb reflectance" [ 0.2 0.3 0.7 ]
Shape "trianglemesh" "point3 P" [ -1 0 -1  1 0 -1  1 2 -1  -1 2 -1 ] "integer indices" [ 0 1 2 0 2 3 ]
Material "diffuse" "rgb reflectance" [ 0.6 0.1 0.1 ]
Shape "trianglemesh" "point3 P" [ -1 0 -1  -1 0 1  -1 2 1  -1 2 -1 ] "integer indices" [ 0 1 2 0 2 3 ]
Material "diffuse" "rgb reflectance" [ 0.1 0.5 0.1 ]
Shape "trianglemesh" "point3 P" [ 1 0 -1  1 0 1  1 2 1  1 2 -1 ] "integer indices" [ 0 1 2 0 2 3 ]
AttributeBegin
  Translate -0.4 0.35 -0.3
  Material "diffuse" "rgb reflectance" [ 0.7 0.6 0.4 ]
  Shape "sphere" "float radius" [ 0.35 ]
AttributeEnd
Include "block.pbrt"
)";

inline constexpr const char* kBlockFile = R"(
AttributeBegin
  Translate 0.4 0 0.2
  Rotate 20 0 1 0
  Material "diffuse" "rgb reflectance" [ 0.5 0.5 0.7 ]
  Shape "trianglemesh"
    "point3 P" [ -0.25 0 -0.25  0.25 0 -0.25  0.25 0.6 -0.25  -0.25 0.6 -0.25  -0.25 0 0.25  0.25 0 0.25  0.25 0.6 0.25  -0.25 0.6 0.25 ]
    "integer indices" [ 0 1 2 0 2 3  4 5 6 4 6 7  0 4 7 0 7 3  1 5 6 1 6 2  3 2 6 3 6 7 ]
AttributeEnd
)";

}  // namespace lodestar
