// Six small scenes that between them have every kind of light and of lobe, and one whose light is hardly found; 24x24
// pixels, box filter.
#pragma once

#include <string>

namespace lodestar::test {

struct SmallScene {
  const char* name;
  std::string text;
};

inline std::string Room(const std::string& inside,
                        const std::string& walls = R"(Material "diffuse" "rgb reflectance" [0.7 0.6 0.5])") {
  // A box from -1 to 1 seen from its open front.
  return R"(Integrator "path" "integer maxdepth" [8]
PixelFilter "box"
Film "rgb" "integer xresolution" [24] "integer yresolution" [24]
LookAt 0 0 -3.4  0 0 0  0 1 0
Camera "perspective" "float fov" [40]
WorldBegin
)" + walls +
         R"(
Shape "trianglemesh" "point3 P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1  -1 1 -1  1 1 -1  1 1 1  -1 1 1]
  "integer indices" [0 2 1 0 3 2  4 5 6 4 6 7  3 6 2 3 7 6  0 4 7 0 7 3  1 2 6 1 6 5]
)" + inside;
}

inline const std::string kLampShutInABox = R"(AttributeBegin
AreaLightSource "diffuse" "rgb L" [60 60 60]
Translate 0.6 -0.6 0.4
Shape "sphere" "float radius" [0.15]
AttributeEnd
Shape "trianglemesh" "point3 P" [0.3 -0.9 0.1  0.9 -0.9 0.1  0.9 -0.9 0.7  0.3 -0.9 0.7  0.3 -0.3 0.1  0.9 -0.3 0.1  0.9 -0.3 0.7  0.3 -0.3 0.7]
  "integer indices" [0 2 1 0 3 2  4 5 6 4 6 7  3 6 2 3 7 6  0 4 7 0 7 3  1 2 6 1 6 5  0 1 5 0 5 4]
)";

inline const SmallScene kSmallScenes[] = {
    // Mostly indirect: the light faces the ceiling.
    {"indirect", Room(R"(AttributeBegin
AreaLightSource "diffuse" "rgb L" [20 18 15]
Material "diffuse" "rgb reflectance" [0 0 0]
Shape "trianglemesh" "point3 P" [-0.3 0.2 -0.3  0.3 0.2 -0.3  0.3 0.2 0.3  -0.3 0.2 0.3] "integer indices" [0 2 1 0 3 2]
AttributeEnd
)")},
    // A glossy metal block under a small light.
    {"glossy",
     Room(
         R"(AttributeBegin
AreaLightSource "diffuse" "rgb L" [60 60 60]
Shape "sphere" "float radius" [0.12]
AttributeEnd
AttributeBegin
Translate 0.3 -0.6 0.1
Material "conductor" "float roughness" [0.15] "bool remaproughness" [false]
Shape "sphere" "float radius" [0.4]
AttributeEnd
)",
         R"(Material "coateddiffuse" "rgb reflectance" [0.6 0.6 0.7] "float roughness" [0.2] "bool remaproughness" [false])")},
    // Glass in front of a light that is not small, so that its caustic converges.
    {"glass", Room(R"(AttributeBegin
AreaLightSource "diffuse" "rgb L" [4 4 5]
Shape "trianglemesh" "point3 P" [-0.9 0.99 -0.9  0.9 0.99 -0.9  0.9 0.99 0.9  -0.9 0.99 0.9] "integer indices" [0 1 2 0 2 3]
AttributeEnd
AttributeBegin
Translate -0.2 -0.5 0
Material "dielectric" "float eta" [1.5] "float roughness" [0.1] "bool remaproughness" [false]
Shape "sphere" "float radius" [0.45]
AttributeEnd
)")},
    // A constant sky through the open front and a thin translucent sheet.
    {"sky", Room(R"(LightSource "infinite" "rgb L" [1 1.2 1.5]
AttributeBegin
Material "diffusetransmission" "rgb reflectance" [0.3 0.3 0.2] "rgb transmittance" [0.4 0.5 0.3]
Shape "disk" "float radius" [0.6]
AttributeEnd
)")},
    // Lights that cannot be hit, and mirrors.
    {"spots",
     Room(R"(LightSource "spot" "rgb I" [6 6 6] "point3 from" [0 0.9 0] "point3 to" [-1 -0.5 0.2] "float coneangle" [35]
LightSource "point" "rgb I" [0.3 0.4 0.5] "point3 from" [0.5 0 -0.5]
AttributeBegin
Translate 0.35 -0.55 0.2
Material "conductor" "float roughness" [0]
Shape "sphere" "float radius" [0.4]
AttributeEnd
AttributeBegin
Translate -0.5 -0.7 -0.2
Material "thindielectric"
Shape "disk" "float radius" [0.3]
AttributeEnd
)")},
    // Lamps in every corner, a bright one shut in a box, and a sky: which light to sample depends on the place.
    {"lamps", Room(R"(LightSource "infinite" "rgb L" [0.2 0.25 0.3]
AttributeBegin
Material "diffuse" "rgb reflectance" [0 0 0]
AreaLightSource "diffuse" "rgb L" [6 5 4]
Shape "trianglemesh" "point3 P" [-0.85 0.98 -0.75  -0.55 0.98 -0.75  -0.55 0.98 -0.45  -0.85 0.98 -0.45] "integer indices" [0 1 2 0 2 3]
Shape "trianglemesh" "point3 P" [0.55 0.98 -0.75  0.85 0.98 -0.75  0.85 0.98 -0.45  0.55 0.98 -0.45] "integer indices" [0 1 2 0 2 3]
Shape "trianglemesh" "point3 P" [-0.85 0.98 0.55  -0.55 0.98 0.55  -0.55 0.98 0.85  -0.85 0.98 0.85] "integer indices" [0 1 2 0 2 3]
AreaLightSource "diffuse" "rgb L" [3 4 6]
Shape "sphere" "float radius" [0.1]
AttributeEnd
)" + kLampShutInABox)},
};

// A screen before a black wall with a square hole. The lamp hangs on the other side of that wall and lights another,
// which is all that the hole sees; past the black wall's edges nothing sees anything. A direction from the screen,
// drawn by the cosine, meets the hole once in 4500 tries.
inline const std::string kPinhole = R"(Integrator "path" "integer maxdepth" [2]
PixelFilter "box"
Film "rgb" "integer xresolution" [24] "integer yresolution" [24]
LookAt 0 0 0.1  0 0 1  0 1 0
Camera "perspective" "float fov" [50]
WorldBegin
Material "diffuse" "rgb reflectance" [0.8 0.8 0.8]
Shape "trianglemesh" "point3 P" [-0.5 -0.5 1  0.5 -0.5 1  0.5 0.5 1  -0.5 0.5 1] "integer indices" [0 2 1 0 3 2]
Shape "trianglemesh" "point3 P" [-0.45 -0.45 -0.8  0.45 -0.45 -0.8  0.45 0.45 -0.8  -0.45 0.45 -0.8] "integer indices" [0 1 2 0 2 3]
Material "diffuse" "rgb reflectance" [0 0 0]
Shape "trianglemesh" "point3 P" [-0.5 -0.5 0  0.5 -0.5 0  0.5 0.5 0  -0.5 0.5 0  0.03 0.03 0  0.06 0.03 0  0.06 0.06 0  0.03 0.06 0]
  "integer indices" [0 1 5 0 5 4  1 2 6 1 6 5  2 3 7 2 7 6  3 0 4 3 4 7]
AreaLightSource "diffuse" "rgb L" [100000 100000 100000]
Shape "trianglemesh" "point3 P" [-0.4 -0.3 -0.02  -0.1 -0.3 -0.02  -0.1 0.3 -0.02  -0.4 0.3 -0.02] "integer indices" [0 2 1 0 3 2]
)";
// What its pixels have on average: the integral over the screen that is seen, the hole and the lamp, by quadrature.
inline constexpr double kPinholeMean = 0.84044;

}  // namespace lodestar::test
