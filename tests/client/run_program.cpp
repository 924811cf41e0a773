#include "tests/client/run_program.h"

#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "client/values.h"
#include "tests/support/temporary_folder.h"

namespace lodestar {

const char kTinyScene[] = R"(
Integrator "path" "integer maxdepth" 4
Sampler "independent" "integer pixelsamples" 4
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Film "rgb" "integer xresolution" 16 "integer yresolution" 12 "string filename" "tiny.exr"
LookAt 0 1 -4  0 0.5 0  0 1 0
Camera "perspective" "float fov" 45
WorldBegin
Material "diffuse" "rgb reflectance" [ 0.5 0.6 0.7 ]
Shape "trianglemesh" "point3 P" [ -5 0 -5  -5 0 5  5 0 5  5 0 -5 ] "integer indices" [ 0 1 2  0 2 3 ]
AreaLightSource "diffuse" "rgb L" [ 5 5 5 ]
Shape "trianglemesh" "point3 P" [ -1 2 -1  1 2 -1  1 2 1  -1 2 1 ] "integer indices" [ 0 1 2  0 2 3 ]
)";

const char kPlainFloor[] = R"(
LookAt 0 1 3  0 0.5 0  0 1 0
Camera "perspective" "float fov" [ 40 ]
Film "rgb" "integer xresolution" [ 16 ] "integer yresolution" [ 12 ]
PixelFilter "box" "float xradius" [ 0.5 ] "float yradius" [ 0.5 ]
Integrator "path" "integer maxdepth" [ 4 ]
WorldBegin
Material "diffuse" "rgb reflectance" [ 0.9 0.9 0.9 ]
Shape "trianglemesh" "point3 P" [ -2 0 -2  2 0 -2  2 0 2  -2 0 2 ] "integer indices" [ 0 1 2 0 2 3 ]
)";

const char kBlindingLight[] = R"(
LightSource "spot" "rgb I" [ 3e38 3e38 3e38 ] "point3 from" [ 0 0.3 0 ] "point3 to" [ 0 0 0 ]
  "float coneangle" [ 15 ] "float conedeltaangle" [ 1 ]
)";

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

Ran RunProgram(const std::vector<std::string>& words, const std::vector<std::string>& environment) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out", err = folder / "err";
  std::string command = "env";
  for (const std::string& word : environment) command += " " + ShellQuote(word);
  for (const std::string& word : words) command += " " + ShellQuote(word);
  command += " >" + ShellQuote(out.string()) + " 2>" + ShellQuote(err.string()) + " </dev/null";
  const int status = std::system(command.c_str());
  Ran ran;
  ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  ran.out = ReadText(out);
  ran.err = ReadText(err);
  return ran;
}

Ran RunLodestar(std::vector<std::string> arguments, const std::vector<std::string>& environment) {
  arguments.insert(arguments.begin(), LODESTAR_PROGRAM);
  return RunProgram(arguments, environment);
}

}  // namespace lodestar
