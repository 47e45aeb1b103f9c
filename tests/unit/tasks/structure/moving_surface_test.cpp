#include "octavo/tasks/structure/moving_surface.h"

#include <cmath>
#include <fstream>

#include "support/task_files.h"

namespace octavo {
namespace {

class MovingSurface : public testing::TaskFiles {
 protected:
  std::string write_text(const std::string& name, const std::string& text) {
    std::ofstream(folder_.file(name), std::ios::binary) << text;
    return folder_.file(name);
  }

  std::string rows(int count, const std::string& more = "") {
    std::string text;
    for (int i = 0; i < count; ++i) {
      text += std::to_string(i) + ", " + std::to_string(i % 3) + "; 2.5" + more + "\r\n";
    }
    return text;
  }

  MovingFeatures read(const std::string& name, const std::string& text,
                      std::int64_t count = 1000) {
    return read_features(write_text(name, text), count, context_);
  }

  Failure failure(const std::string& name, const std::string& text) {
    return failure_of([&] { read(name, text); });
  }
};

TEST_F(MovingSurface, RowsOfThreeArePointsAndOfSixLines) {
  const MovingFeatures points = read("a.csv", "x,y,z\n# of a probe\n" + rows(30));
  EXPECT_EQ(points.points.size(), 30u);
  EXPECT_NEAR(points.spacing_mm, std::sqrt(2), 1e-9);
  EXPECT_EQ(read("a.txt", rows(70), 32).points.size(), 32u);
  std::string crossing = rows(15, " 90 1 1");
  for (int i = 0; i < 15; ++i) crossing += "0 " + std::to_string(i) + " 0 5 800 1\n";
  EXPECT_EQ(read("a.xyz", crossing).lines.size(), 30u);
}

TEST_F(MovingSurface, RowsThatAreNoneAreRejectedByTheirLine) {
  const Failure short_row = failure("b.csv", rows(30) + "1,2\n");
  EXPECT_EQ(short_row.kind, ErrorKind::source_rejected);
  EXPECT_NE(short_row.detail.find("line 31"), std::string::npos) << short_row.detail;
  EXPECT_EQ(failure("b.csv", "1 2 3 4\n").kind, ErrorKind::source_rejected);
  EXPECT_EQ(failure("b.csv", "1 2 nan\n").kind, ErrorKind::source_rejected);
  EXPECT_EQ(failure("b.csv", "1 2 1e300\n").kind, ErrorKind::source_rejected);
  EXPECT_EQ(failure("b.csv", "x y z\nx y z\n").kind, ErrorKind::source_rejected);
  EXPECT_EQ(failure("b.csv", "1 2 3 1 2 3\n").kind, ErrorKind::source_rejected);
}

TEST_F(MovingSurface, TooLittleIsRejected) {
  EXPECT_EQ(failure("c.csv", "").kind, ErrorKind::invalid_argument);
  EXPECT_EQ(failure("c.csv", rows(29)).kind, ErrorKind::invalid_argument);
  EXPECT_EQ(failure("c.csv", rows(40, " 900 1 1")).kind, ErrorKind::invalid_argument);
  EXPECT_EQ(failure("c.dat", rows(30)).kind, ErrorKind::invalid_argument);
}

TEST_F(MovingSurface, MeshesGivePlacesOnTheirTriangles) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\n";
  const std::string corners = "0 0 5\n8 0 5\n8 8 5\n0 8 5\n";
  const MovingFeatures mesh =
      read("d.ply", header + "element face 1\nproperty list uchar int vertex_indices\n" +
                        "end_header\n" + corners + "4 0 1 2 3\n");
  ASSERT_EQ(mesh.points.size(), 1000u);
  double left = 0;
  for (const Point3& p : mesh.points) {
    EXPECT_NEAR(p[2], 5, 1e-9);
    EXPECT_TRUE(p[0] >= 0 && p[0] <= 8 && p[1] >= 0 && p[1] <= 8);
    left += p[0] < 2 ? 1 : 0;
  }
  EXPECT_NEAR(left, 250, 45);
  // Points alone: four are too few.
  EXPECT_EQ(failure("e.ply", header + "end_header\n" + corners).kind,
            ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace octavo
