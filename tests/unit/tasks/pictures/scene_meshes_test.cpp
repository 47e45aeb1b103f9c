#include "octavo/tasks/pictures/scene_meshes.h"

#include <gtest/gtest.h>

#include <fstream>

#include "octavo/core/error.h"
#include "octavo/mesh/mesh_check.h"
#include "support/built_file.h"

namespace octavo {
namespace {

class SceneMeshFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    context_.on_warning = [this](const Warning& warning) { said_ += warning.text; };
    context_.on_note = [this](const std::string& text, const std::string&) { said_ += text; };
  }

  void ask_for(const std::string& name, const std::string& text) {
    std::ofstream(folder_.file(name)) << text;
    options_.meshes = {{folder_.file(name), std::nullopt, 1}};
  }

  SceneMeshes read() { return {options_, {}, {{0, 0, 0}, {20, 20, 20}}, context_}; }

  void expect_error(ErrorKind kind, const char* text) {
    try {
      read();
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind);
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  }

  static constexpr const char* kTetrahedron =
      "v 2 2 2\nv 8 2 2\nv 2 8 2\nv 2 2 8\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

  testing::ScratchFolder folder_;
  RenderOptions options_;
  TaskContext context_;
  std::string said_;
};

TEST_F(SceneMeshFiles, AreReadWithNormalsAndANameInTheLegend) {
  ask_for("body.obj", kTetrahedron);
  options_.meshes[0].color = Color{1, 2, 3};
  options_.meshes[0].opacity = 0.25;
  const SceneMeshes scene = read();
  const std::vector<RayMesh> meshes = scene.meshes();
  ASSERT_EQ(meshes.size(), 1u);
  EXPECT_EQ(meshes[0].mesh->triangles.size(), 4u);
  EXPECT_EQ(meshes[0].normals.size(), 4u);
  EXPECT_EQ(meshes[0].color, (Color{1, 2, 3}));
  EXPECT_EQ(meshes[0].opacity, 0.25);
  ASSERT_EQ(scene.legend().size(), 1u);
  EXPECT_EQ(scene.legend()[0].text, "body.obj");
  EXPECT_GT(scene.memory_bytes(), 4 * sizeof(MeshPoint));
  EXPECT_EQ(said_, "");
}

TEST_F(SceneMeshFiles, ThatAreRasAreTurned) {
  ask_for("body.obj", std::string("# SPACE=RAS\n") + kTetrahedron);
  const SceneMeshes scene = read();
  EXPECT_EQ(scene.meshes()[0].mesh->points[1], (MeshPoint{-8, -2, 2}));
  EXPECT_NE(said_.find("lies beside the volume: along its x axis from -8 to -2"),
            std::string::npos)
      << said_;
}

TEST_F(SceneMeshFiles, MarksElsewhereAreNoted) {
  options_.marks.resize(2);
  options_.marks[0].at_mm = {3, 3, 3};
  options_.marks[1] = {{300, 3, 3}, "far", std::nullopt};
  read();
  EXPECT_NE(said_.find("the mark far: lies beside the volume: along its x axis"),
            std::string::npos)
      << said_;
  EXPECT_EQ(said_.find("a mark"), std::string::npos) << said_;
}

TEST_F(SceneMeshFiles, ThatAreOpenAreNoted) {
  ask_for("open.obj", "v 2 2 2\nv 8 2 2\nv 2 8 2\nf 1 2 3\n");
  read();
  EXPECT_NE(said_.find("is open at 3 sides"), std::string::npos) << said_;
}

TEST_F(SceneMeshFiles, ThatAreNoneAreRejectedByName) {
  ask_for("notes.txt", "");
  expect_error(ErrorKind::invalid_argument, "a mesh that is drawn is one of .stl, .ply or .obj");
  ask_for("broken.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  expect_error(ErrorKind::truncated, "broken.ply");
  options_.meshes = {{folder_.file("missing.stl"), std::nullopt, 1}};
  expect_error(ErrorKind::io, "missing.stl");
  ask_for("body.obj", kTetrahedron);
  context_.max_memory_bytes = 100;
  expect_error(ErrorKind::limit_exceeded, "more than");
}

TEST_F(SceneMeshFiles, MarksAreClosedBallsAtTheirPlaces) {
  const MeshBall ball = mesh_ball({3, 4, 5}, 2);
  const MeshCheck check = check_mesh(ball.mesh);
  EXPECT_EQ(check.open_sides, 0u);
  const double volume = measure_mesh(ball.mesh).volume_mm3;
  EXPECT_NEAR(volume, 4.18879 * 8, 1.5);
  options_.marks = {{{3, 4, 5}, "here", std::nullopt}};
  const SceneMeshes scene = read();
  ASSERT_EQ(scene.meshes().size(), 1u);
  EXPECT_TRUE(scene.legend().empty());
}

}  // namespace
}  // namespace octavo
