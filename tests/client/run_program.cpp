#include "tests/client/run_program.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "client/values.h"

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

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

Ran RunProgram(const std::vector<std::string>& words, const std::vector<std::string>& environment) {
  static int count = 0;
  const std::string base = (std::filesystem::temp_directory_path() /
                            ("lodestar-ran-" + std::to_string(getpid()) + "-" + std::to_string(count++)))
                               .string();
  std::string command = "env";
  for (const std::string& word : environment) command += " " + ShellQuote(word);
  for (const std::string& word : words) command += " " + ShellQuote(word);
  command += " >" + ShellQuote(base + ".out") + " 2>" + ShellQuote(base + ".err") + " </dev/null";
  const int status = std::system(command.c_str());
  Ran ran;
  ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  ran.out = ReadText(base + ".out");
  ran.err = ReadText(base + ".err");
  std::filesystem::remove(base + ".out");
  std::filesystem::remove(base + ".err");
  return ran;
}

Ran RunLodestar(std::vector<std::string> arguments, const std::vector<std::string>& environment) {
  arguments.insert(arguments.begin(), LODESTAR_PROGRAM);
  return RunProgram(arguments, environment);
}

TestFolder::TestFolder() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  path_ =
      std::filesystem::temp_directory_path() / ("lodestar-" + std::to_string(getpid()) + "-" +
                                                std::string(test->test_suite_name()) + "-" + std::string(test->name()));
  std::filesystem::remove_all(path_);
  std::filesystem::create_directories(path_);
}

TestFolder::~TestFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path TestFolder::Write(const std::string& name, const std::string& text) const {
  std::ofstream(path_ / name, std::ios::binary) << text;
  return path_ / name;
}

}  // namespace lodestar
