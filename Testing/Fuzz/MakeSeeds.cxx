// SPDX-License-Identifier: BSD-3-Clause
// Writes small right files of every format into the folder given, one subfolder per fuzzer.
#include "Quadflow/QuadflowCase.h"
#include "Quadflow/QuadflowFormat.h"

#ifdef BSV_WITH_CGNS
#include <vtk_cgns.h>
// clang-format off
#include VTK_CGNS(cgnslib.h)
// clang-format on
#endif

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace
{

std::filesystem::path Folder;

std::string pathOf(const std::string& fuzzer, const std::string& name)
{
  std::filesystem::create_directories(Folder / fuzzer);
  return (Folder / fuzzer / name).string();
}

void write(const std::string& fuzzer, const std::string& name, const std::string& content)
{
  std::ofstream(pathOf(fuzzer, name), std::ios::binary) << content;
}

/// x, y, z of the points of a box, one axis after the other.
std::string gridText(int ni, int nj, int nk, double shift)
{
  std::ostringstream text;
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int k = 0; k < nk; ++k)
    {
      for (int j = 0; j < nj; ++j)
      {
        for (int i = 0; i < ni; ++i)
        {
          const double place[3] = { shift + i, double(j), double(k) };
          text << place[axis] << (i + 1 < ni ? " " : "\n");
        }
      }
    }
  }
  return text.str();
}

void plot3D()
{
  // The first byte holds the fuzzer's options.
  write("Plot3D", "two", std::string(1, '\0') + "2\n2 3 2\n2 2 2\n" + gridText(2, 3, 2, 0.0) + gridText(2, 2, 2, 1.0));
  write("Plot3D", "one", std::string(1, '\0') + "2 2 2\n" + gridText(2, 2, 2, 0.0) + "8*1\n");
  write("Plot3D", "repeats",
    std::string(1, '\0') +
      "1\n 3*2\n2*0., 2*1.D0 ,+0 -0\t1 ,1\n0,0.0e+0,1.5d-1,1.5Q-01,"
      "2*.0,2*+.15\n4*1-3, 4*2.5-100\n");
  write("Plot3D", "negative", std::string(1, '\0') + " -1");
  // So many blocks that all their counts together take long, and the first one promises more than the file has.
  write("Plot3D", "manyBlocks", std::string(1, '\0') + "28228298\n9496729*98\n9496729*1");
  write("Plot3D", "mark", std::string(1, '\0') + "\xef\xbb\xbf" + "1 2 2 2\n" + gridText(2, 2, 2, 0.0));
}

void neutralMap()
{
  const std::string blocks = "# two\n2\n1 3 3 3\n2 3 3 3\n";
  write("NeutralMap", "contact", blocks + "ONE_TO_ONE 1 4 1 3 1 3  2 3 1 3 1 3 FALSE\nwall 1 1 1 3 1 3\n");
  write("NeutralMap", "quoted",
    blocks +
      "'one-to-one  ' 1 4 1 3 1 3  2 3 1 3 1 3 .FALSE.\n'far field' 2 4 1 3 1 3\n"
      "1 to 1 2 3 1 3 1 3 1 4 1 3 1 3 F\n");
  write("NeutralMap", "odd", blocks + "viscous solid 1 1 1 3 1 2\nwall 9 1 1 3 1 3\nPATCHED 1 2 1 3 1 3\n");
}

void g2()
{
  const std::string knots = "2 2\n0 0 1 1\n";
  write("G2", "surface", "200 1 0 0\n3 0\n" + knots + knots + "0 0 0\n1 0 0\n0 1 0\n1 1 0\n");
  write("G2", "rational", "200 1 0 0\n3 1\n" + knots + knots + "0 0 0 1\n1 0 0 1\n0 1 0 .5\n1 1 0 1\n");
  write("G2", "curve", "100 1 0 0\n3 0\n" + knots + "0 0 0\n1 0 0\n");
  write("G2", "volume",
    "700 1 0 0\n3 0\n" + knots + knots + knots + "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n");
}

/// Two patches of degree 2 side by side, in a space: all degrees of freedom of edges, faces and insides count. The
/// second patch begins at another of its corners, so that the points of the shared face are numbered otherwise.
std::string twoPatchSpace(const std::string& second, int version, const std::string& spacing)
{
  std::ostringstream text;
  text << "MFEM NURBS mesh v1." << version << "\n\ndimension\n3\n\nelements\n2\n1 5 0 1 4 3 6 7 10 9\n1 5 " << second
       << "\n\nboundary\n1\n1 3 0 3 4 1\n\nedges\n20\n";
  const auto vertex = [](int i, int j, int k) { return i + 3 * (j + 2 * k); };
  for (int k = 0; k < 2; ++k)
  {
    for (int j = 0; j < 2; ++j)
    {
      text << "0 " << vertex(0, j, k) << ' ' << vertex(1, j, k) << "\n3 " << vertex(1, j, k) << ' ' << vertex(2, j, k)
           << '\n';
    }
    for (int i = 0; i < 3; ++i)
    {
      text << "1 " << vertex(i, 0, k) << ' ' << vertex(i, 1, k) << '\n';
    }
  }
  for (int n = 0; n < 6; ++n)
  {
    text << "2 " << n << ' ' << n + 6 << '\n';
  }
  text << "\nvertices\n12\n\n"
       << "knotvectors\n4\n";
  for (int n = 0; n < 4; ++n)
  {
    text << "2 4 0 0 0 1 2 2 2\n";
  }
  text << spacing;
  // Points: 12 + 2 on each edge + 4 on each face + 8 in each patch.
  constexpr int Points = 12 + 2 * 20 + 4 * 11 + 8 * 2;
  text << "\nweights\n";
  for (int n = 0; n < Points; ++n)
  {
    text << "1\n";
  }
  text << "\nFiniteElementSpace\nFiniteElementCollection: NURBS2\nVDim: 3\nOrdering: 1\n\n";
  for (int n = 0; n < Points; ++n)
  {
    text << n << ' ' << n * n % 7 << " 0.5\n";
  }
  return text.str();
}

void mfem()
{
  const std::string topology = "MFEM NURBS mesh v1.0\n\n# comment\ndimension\n3\n\nelements\n1\n1 5 0 1 2 3 4 5 6 7\n\n"
                               "boundary\n2\n1 3 0 3 2 1\n2 3 4 5 6 7\n\n";
  const std::string edges = "edges\n12\n0 0 1\n0 3 2\n0 4 5\n0 7 6\n1 0 3\n1 1 2\n1 4 7\n1 5 6\n2 0 4\n2 1 5\n2 2 6\n"
                            "2 3 7\n\nvertices\n8\n\n";
  std::string points;
  for (int v = 0; v < 8; ++v)
  {
    points += std::to_string(v & 1) + " " + std::to_string(v >> 1 & 1) + " " + std::to_string(v >> 2) + " 1\n";
  }
  write("MFEM", "patches",
    topology + edges +
      "patches\n\nknotvectors\n3\n1 2 0 0 1 1\n1 2 0 0 1 1\n1 2 0 0 1 1\n\ndimension\n3\n\ncontrolpoints_cartesian\n" +
      points);
  write("MFEM", "space",
    topology + edges +
      "knotvectors\n3\n1 2 0 0 1 1\n1 2 0 0 1 1\n1 2 0 0 1 1\n\nweights\n1\n1\n1\n1\n1\n1\n1\n1\n\n"
      "FiniteElementSpace\nFiniteElementCollection: NURBS1\nVDim: 3\nOrdering: 1\n\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n");
  write("MFEM", "twoPatches", twoPatchSpace("1 2 5 4 7 8 11 10", 0, ""));
  write("MFEM", "turnedPatch", twoPatchSpace("11 10 7 8 5 4 1 2", 0, ""));
  write("MFEM", "spacing", twoPatchSpace("4 1 2 5 10 7 8 11", 1, "\nspacing\n1\n0 1 2 1 3 5 2.5\n"));
}

/// Eighty columns with section and number.
std::string card(const std::string& text, char section, int number)
{
  char end[16];
  std::snprintf(end, sizeof(end), "%c%7d", section, number);
  std::string line = text;
  line.resize(72, ' ');
  return line + end + "\n";
}

void cadText()
{
  write("CADText", "step",
    "ISO-10303-21;\nHEADER;\nFILE_NAME('a','b');\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\n"
    "#2=DIRECTION('',(0.,0.,1.));\n#3=AXIS2_PLACEMENT_3D('',#1,#2,$);\n#4=PLANE('',#3);\n"
    "#5=ADVANCED_FACE('',(#6),#4,.T.);\n#6=FACE_BOUND('',#7,.T.);\n#7=VERTEX_LOOP('',#8);\n#8=VERTEX_POINT('',#1);\n"
    "#9=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#10)));\n#10=(LENGTH_UNIT()NAMED_UNIT(*));\n"
    "#11=SHAPE_REPRESENTATION('',(#5),#9);\n#12=CURVE_STYLE('',#99,$,$);\n/* end */\nENDSEC;\nEND-ISO-10303-21;\n");
  write("CADText", "iges",
    card("note", 'S', 1) + card("1H,,1H;,4Ha.ig,4Ha.ig,1Hx,1Hx,32,38,6,308,15,4Ha.ig,1.,2,2HMM,1,1.,", 'G', 1) +
      card("     116       1       0       0       0       0       0       000000000", 'D', 1) +
      card("     116       0       0       1       0                               0", 'D', 2) +
      card("116,0.,0.,0.,0;                                                        1", 'P', 1) +
      card("S      1G      1D      2P      1", 'T', 1));
  write("CADText", "brep",
    "DBRep_DrawableShape\n\nCASCADE Topology V1, (c) Matra-Datavision\nLocations 0\nCurve2ds 0\nCurves 0\nPolygon3D 0\n"
    "PolygonOnTriangulations 0\nSurfaces 0\nTriangulations 0\n\nTShapes 1\nCo\n\n1100000\n*\n\n+1 0 \n");
}

void quadflow()
{
  // Two blocks of 2 x 1 x 1 spans, side by side along i.
  std::vector<std::vector<double>> points(2);
  bsv::QuadflowInput input;
  for (int b = 0; b < 2; ++b)
  {
    bsv::BSplineVolume volume;
    volume.knots = { bsv::clampedIntegerKnots(2), bsv::clampedIntegerKnots(1), bsv::clampedIntegerKnots(1) };
    for (int k = 0; k < volume.count(2); ++k)
    {
      for (int j = 0; j < volume.count(1); ++j)
      {
        for (int i = 0; i < volume.count(0); ++i)
        {
          points[b].insert(points[b].end(), { 4.0 * b + i, double(j), double(k) });
        }
      }
    }
    volume.points = points[b].data();
    input.volumes.push_back(volume);
    input.names.push_back("block " + std::to_string(b));
    input.rules.push_back(nullptr);
  }
  input.boundaryNames = { "wall" };
  input.boundaries = { { 0, 4, {}, 0 } };
  const bsv::QuadflowCase all = bsv::makeQuadflowCase(input);
  bsv::QuadflowOptions options;
  bsv::writeQuadflow(all, pathOf("Quadflow", "text"), options);
  options.binary = true;
  bsv::writeQuadflow(all, pathOf("Quadflow", "binary"), options);
}

void series()
{
  write("Series", "two",
    "{\n\"file-series-version\": \"1.0\",\n\"files\": [\n{ \"name\": \"a.xyz\", \"time\": 0 },\n"
    "{ \"name\": \"b\\u00fc.xyz\", \"time\": 1.5e0 }\n]\n}\n");
  write("Series", "odd", "{\"files\":[{\"x\":\"\\ud83d\\ude00\\t\",\"name\":\"/a\"},{\"name\":\"b\",\"other\":true}]}");
}

void cgnsTree()
{
#ifdef BSV_WITH_CGNS
  for (const int type : { CG_FILE_ADF, CG_FILE_HDF5 })
  {
    int file = 0;
    int id = 0;
    const cgsize_t size[9] = { 2, 2, 2, 1, 1, 1, 0, 0, 0 };
    const cgsize_t range[6] = { 1, 1, 1, 1, 2, 2 };
    const std::vector<float> values(8, 0.5f);
    cg_set_file_type(type);
    cg_open(pathOf("CGNSTree", type == CG_FILE_ADF ? "adf" : "hdf5").c_str(), CG_MODE_WRITE, &file);
    cg_base_write(file, "Base", 3, 3, &id);
    cg_zone_write(file, 1, "zone", size, CGNS_ENUMV(Structured), &id);
    for (const char* axis : { "CoordinateX", "CoordinateY", "CoordinateZ" })
    {
      cg_coord_write(file, 1, 1, CGNS_ENUMV(RealSingle), axis, values.data(), &id);
    }
    cg_boco_write(file, 1, 1, "wall", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointRange), 2, range, &id);
    cg_close(file);
  }
#endif
}

} // namespace

int main(int argumentCount, char** arguments)
{
  if (argumentCount != 2)
  {
    std::fprintf(stderr, "usage: MakeSeeds <folder>\n");
    return 1;
  }
  Folder = arguments[1];
  plot3D();
  neutralMap();
  g2();
  mfem();
  cadText();
  quadflow();
  series();
  cgnsTree();
  return 0;
}
