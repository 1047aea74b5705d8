// SPDX-License-Identifier: BSD-3-Clause
#include "Body/ClosestPoint.h"
#include "Body/TrimRegion.h"
#include "Data/NURBSSurfaceData.h"
#include "Support/BodyCases.h"
#include "Support/Files.h"
#include "Support/Messages.h"
#include "Support/ThreadRanks.h"
#include "vtkNURBSSurfaceReader.h"

#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataAssembly.h>
#include <vtkDoubleArray.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iomanip>
#include <iterator>
#include <sstream>

#ifdef BSPLINEVOLUME_WITH_OPENCASCADE
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <GProp_GProps.hxx>
#include <Geom_BSplineSurface.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Writer.hxx>
#include <TopExp.hxx>
#include <TopLoc_Location.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Compound.hxx>
#endif

using namespace bodycases;
using namespace bsv;
using namespace bsvtest;

namespace
{

struct Reading
{
  vtkNew<vtkNURBSSurfaceReader> reader;
  std::vector<std::string> errors;
  std::vector<std::string> warnings;
  vtkPartitionedDataSetCollection* output = nullptr;
  /// What was printed while reading.
  std::string printed;

  void read(const std::string& fileName)
  {
    const bsvtest::Messages messages(this->reader, this->errors, this->warnings);
    vtkNew<vtkCallbackCommand> silence;
    this->reader->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, silence);
    this->reader->SetFileName(fileName.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    this->reader->Update();
    this->printed = testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
    this->output = vtkPartitionedDataSetCollection::SafeDownCast(this->reader->GetOutputDataObject(0));
    EXPECT_EQ(this->printed, "");
  }

  std::vector<BodyPatch> patches() const { return bodyPatches(this->output); }
  vtkPolyData* surface() const
  {
    return vtkPolyData::SafeDownCast(
      this->output->GetPartitionAsDataObject(this->output->GetNumberOfPartitionedDataSets() - 1, 0));
  }
};

/// Reads a file that must be refused: one error that names it, an error code, nothing in the output. Returns the error.
std::string refused(const std::string& fileName)
{
  Reading reading;
  reading.read(fileName);
  EXPECT_EQ(reading.errors.size(), 1u) << fileName;
  EXPECT_NE(reading.reader->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::NoError)) << fileName;
  EXPECT_EQ(reading.output->GetNumberOfPartitionedDataSets(), 0u) << fileName;
  std::string error = reading.errors.empty() ? "" : reading.errors[0];
  EXPECT_NE(error.find(fileName), std::string::npos) << error;
  return error;
}

std::string sharedFile(const std::string& name)
{
  const char* folder = std::getenv("BSV_SHARED_DATA");
  const std::string path = std::string(folder ? folder : "") + "/surfaces/" + name;
  return folder && std::filesystem::exists(path) ? path : "";
}

std::string g2(const NURBSSurface& s)
{
  std::ostringstream text;
  text << std::setprecision(17) << "200 1 0 0\n3 " << s.rational() << "\n";
  for (int d = 0; d < 2; ++d)
  {
    text << s.count(d) << " " << s.degree[d] + 1 << "\n";
    for (const double knot : s.knots[d])
    {
      text << knot << " ";
    }
    text << "\n";
  }
  for (std::size_t i = 0; i < s.points.size(); ++i)
  {
    const double w = s.rational() ? s.weights[i] : 1.0;
    text << w * s.points[i][0] << " " << w * s.points[i][1] << " " << w * s.points[i][2];
    text << (s.rational() ? " " : "");
    s.rational() ? text << w << "\n" : text << "\n";
  }
  return text.str();
}

/// The tessellation lies on its patches, and covers their area.
void checkTessellation(const Reading& reading)
{
  const std::vector<BodyPatch> patches = reading.patches();
  vtkPolyData* surface = reading.surface();
  ASSERT_NE(surface, nullptr);
  auto* ids = vtkIntArray::SafeDownCast(surface->GetPointData()->GetArray("PatchId"));
  auto* uv = vtkDoubleArray::SafeDownCast(surface->GetPointData()->GetArray("UV"));
  vtkDataArray* normals = surface->GetPointData()->GetNormals();
  ASSERT_TRUE(ids && uv && normals);
  EXPECT_STREQ(normals->GetName(), "Normals");
  for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i)
  {
    const BodyPatch& patch = patches.at(ids->GetValue(i));
    const SurfaceGeometry at =
      surfaceGeometry(patch.surface, uv->GetComponent(i, 0), uv->GetComponent(i, 1), patch.reversed);
    Vec3 x;
    surface->GetPoint(i, x.data());
    EXPECT_EQ(x, at.point);
    EXPECT_EQ(Vec3(normals->GetTuple(i)), at.normal);
  }
  std::vector<double> covered(patches.size(), 0.0);
  double outward = 0.0;
  for (vtkIdType c = 0; c < surface->GetNumberOfCells(); ++c)
  {
    vtkIdType count;
    const vtkIdType* ends;
    surface->GetPolys()->GetCellAtId(c, count, ends);
    ASSERT_EQ(count, 3);
    Vec3 p[3];
    for (int k = 0; k < 3; ++k)
    {
      surface->GetPoint(ends[k], p[k].data());
    }
    const Vec3 twice = (p[1] - p[0]).cross(p[2] - p[0]);
    covered[ids->GetValue(ends[0])] += 0.5 * twice.norm();
    outward += twice.dot(Vec3(normals->GetTuple(ends[0]))) > 0.0 ? 0.5 * twice.norm() : 0.0;
  }
  double total = 0.0;
  double whole = 0.0;
  for (std::size_t i = 0; i < patches.size(); ++i)
  {
    total += covered[i];
    whole += patchArea(patches[i], 1e-6);
  }
  EXPECT_NEAR(total / whole, 1.0, 0.01);
  EXPECT_GT(outward / total, 0.99);
}

} // namespace

TEST(NURBSSurfaceReader, G2KeepsEveryBit)
{
  const TemporaryFolder folder;
  NURBSSurface plain = bumpy(1, { 3, 2 }, { 4, 3 }, 0.3, false);
  NURBSSurface rational = bumpy(2, { 4, 3 }, { 2, 3 }, 0.3, true);
  for (double& weight : rational.weights)
  {
    // Powers of two: the format stores points times weights, which then is exact.
    weight = weight > 1.0 ? 2.0 : 0.5;
  }
  writeFile(folder / "body.g2", g2(plain) + "\n" + g2(rational));
  Reading reading;
  reading.read(folder / "body.g2");
  ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
  EXPECT_TRUE(reading.warnings.empty());
  const std::vector<BodyPatch> patches = reading.patches();
  ASSERT_EQ(patches.size(), 2u);
  for (int p = 0; p < 2; ++p)
  {
    const NURBSSurface& expected = p == 0 ? plain : rational;
    EXPECT_EQ(patches[p].surface.degree, expected.degree);
    EXPECT_EQ(patches[p].surface.knots, expected.knots);
    EXPECT_EQ(patches[p].surface.points, expected.points);
    EXPECT_EQ(patches[p].surface.weights, expected.weights);
    EXPECT_TRUE(patches[p].loops.empty());
  }
  EXPECT_STREQ(reading.reader->GetFormat(), "GoTools g2");
  EXPECT_STREQ(reading.reader->GetDeclaredUnit(), "unknown");
  vtkDataAssembly* assembly = reading.output->GetDataAssembly();
  EXPECT_STREQ(assembly->GetRootNodeName(), "body");
  const int parent = assembly->GetFirstNodeByPath("/body/patches");
  EXPECT_EQ(assembly->GetNumberOfChildren(parent), 2);
  EXPECT_EQ(assembly->GetDataSetIndices(assembly->GetFirstNodeByPath("/body/surface")), std::vector<unsigned int>{ 2 });
  EXPECT_STREQ(reading.output->GetMetaData(0u)->Get(vtkCompositeDataSet::NAME()), "Surface 1");
  checkTessellation(reading);
}

TEST(NURBSSurfaceReader, PatchesSurviveTheirDataObjects)
{
  std::vector<BodyPatch> patches{ { "same name", sphere(1.0), {}, true },
    { "same name", rectangle(10, 8), { circleLoop({ 5, 4 }, 2.0), circleLoop({ 5, 4 }, 1.0) }, false },
    { "", torus(3, 1), {}, false } };
  patches[1].loops[1].push_back({ 1, { 0, 0, 1, 1 }, { { 1, 1 }, { 2, 2 } }, {} });
  vtkNew<vtkPartitionedDataSetCollection> collection;
  setBody(collection, patches, { "", "7", "" }, nullptr);
  const auto expectSame = [&](const std::vector<BodyPatch>& back) {
    ASSERT_EQ(back.size(), patches.size());
    for (std::size_t i = 0; i < patches.size(); ++i)
    {
      EXPECT_EQ(back[i].name, patches[i].name.empty() ? "Patch_2" : patches[i].name);
      EXPECT_EQ(back[i].surface.degree, patches[i].surface.degree);
      EXPECT_EQ(back[i].reversed, patches[i].reversed);
      EXPECT_EQ(back[i].surface.knots, patches[i].surface.knots);
      EXPECT_EQ(back[i].surface.points, patches[i].surface.points);
      EXPECT_EQ(back[i].surface.weights, patches[i].surface.weights);
      ASSERT_EQ(back[i].loops.size(), patches[i].loops.size());
      for (std::size_t l = 0; l < patches[i].loops.size(); ++l)
      {
        ASSERT_EQ(back[i].loops[l].size(), patches[i].loops[l].size());
        for (std::size_t c = 0; c < patches[i].loops[l].size(); ++c)
        {
          EXPECT_EQ(back[i].loops[l][c].degree, patches[i].loops[l][c].degree);
          EXPECT_EQ(back[i].loops[l][c].knots, patches[i].loops[l][c].knots);
          EXPECT_EQ(back[i].loops[l][c].points, patches[i].loops[l][c].points);
          EXPECT_EQ(back[i].loops[l][c].weights, patches[i].loops[l][c].weights);
        }
      }
    }
  };
  expectSame(bodyPatches(collection));

  // On several ranks: each has some of the patches, one of them none; all get all.
  for (int size = 2; size <= 4; ++size)
  {
    const auto errors = bsvtest::onRanks(size, [&](const Execution& run) {
      vtkNew<vtkPartitionedDataSetCollection> part;
      part->ShallowCopy(collection);
      for (unsigned int p = 0; p < part->GetNumberOfPartitionedDataSets(); ++p)
      {
        if (run.ranks->rank() != static_cast<int>(1 + p % (size - 1)) && (p != 1 || run.ranks->rank() != 2))
        {
          part->SetNumberOfPartitions(p, 0);
        }
      }
      expectSame(bodyPatches(part, *run.ranks));
      // What all have is not sent: the points alone would be more than this.
      const Index received = run.ranks->receivedBytes();
      const Index points = static_cast<Index>(sizeof(double) * 3 * patches[0].surface.points.size());
      EXPECT_TRUE(run.ranks->rank() > 0 || received > points);
      expectSame(bodyPatches(collection, *run.ranks));
      EXPECT_LT(run.ranks->receivedBytes() - received, points);
      EXPECT_THROW(bodyPatches(nullptr, *run.ranks), Error);
    });
    EXPECT_EQ(errors, std::vector<std::string>(size));
  }

  // Damaged arrays name the patch and the array.
  auto* grid = vtkStructuredGrid::SafeDownCast(collection->GetPartitionAsDataObject(1, 0));
  vtkIntArray::SafeDownCast(grid->GetFieldData()->GetArray("TrimCurves"))->SetValue(2, 1000000);
  try
  {
    bodyPatches(collection);
    FAIL();
  }
  catch (const Error& error)
  {
    EXPECT_NE(std::string(error.what()).find("patch 1 'same name': field data array 'TrimCurves'"), std::string::npos)
      << error.what();
  }
  vtkNew<vtkPolyData> nothing;
  EXPECT_THROW(bodyPatches(nothing), Error);
  EXPECT_THROW(bodyPatches(nullptr), Error);
}

TEST(NURBSSurfaceReader, UnitsAreScaledOnDemand)
{
  const TemporaryFolder folder;
  const NURBSSurface plain = bumpy(1, { 3, 2 }, { 4, 3 }, 0.3, false);
  writeFile(folder / "body.g2", g2(plain));
  Reading reading;
  reading.reader->SetLengthUnit(vtkNURBSSurfaceReader::METRE);
  reading.reader->SetFileUnit(vtkNURBSSurfaceReader::MILLIMETRE);
  reading.read(folder / "body.g2");
  ASSERT_TRUE(reading.errors.empty());
  const std::vector<BodyPatch> patches = reading.patches();
  for (std::size_t i = 0; i < plain.points.size(); ++i)
  {
    EXPECT_EQ(patches[0].surface.points[i], plain.points[i] / 1000.0);
  }
  // The file itself says nothing.
  Reading unknown;
  unknown.reader->SetLengthUnit(vtkNURBSSurfaceReader::METRE);
  unknown.read(folder / "body.g2");
  ASSERT_EQ(unknown.errors.size(), 1u);
  EXPECT_NE(unknown.errors[0].find("FileUnit"), std::string::npos) << unknown.errors[0];
}

TEST(NURBSSurfaceReader, WrongG2FilesAreRefusedWithTheirLine)
{
  const TemporaryFolder folder;
  const std::string good = g2(bumpy(3, { 2, 2 }, { 2, 2 }, 0.3, true));
  const auto broken = [&](const std::string& text, const std::string& part) {
    writeFile(folder / "bad.g2", text);
    const std::string error = refused(folder / "bad.g2");
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos);
    return text.replace(at, from.size(), to);
  };
  broken("", "the file is empty");
  broken("hello\n", "neither an IGES");
  broken("200", "neither");
  broken("200 1 0 0\n", "line 2: the file ends where the dimension");
  broken("210 1 0 0\n200\n", "line 1: class 210 (bounded (trimmed) surface) is not supported");
  broken("700 1 0 0\n3 0\n", "class 700 (spline volume)");
  broken(replaced("3 1\n", "2 1\n"), "line 2: the surface has dimension 2");
  broken(replaced("3 1\n", "3 7\n"), "line 2: the rational flag is 7");
  broken(replaced("4 3\n", "400000000 3\n"), "line 3: the number of control points is 400000000");
  broken(replaced("4 3\n", "40000000 3\n"), "line 3: the file is too short");
  broken(replaced("4 3\n", "4 9\n"), "line 3: the order 9 exceeds");
  broken(replaced("4 3\n", "4 x\n"), "line 3: 'x' is no whole number");
  broken(replaced("0 0 0 ", "0 0 nan "), "line 4: 'nan' is no finite number");
  broken(replaced("0 0 0 ", "0 1e999 0 "), "line 4");
  broken(replaced("0 0 0 ", "0 2 0 "), "line 4: a knot is smaller");
  broken(good + "garbage", "'garbage' is no whole number");
  // Cut anywhere, as long as a number is missing; the first cards alone are another format, or none.
  for (std::size_t size = 12; size + 30 < good.size(); size += 37)
  {
    writeFile(folder / "cut.g2", good.substr(0, size));
    refused(folder / "cut.g2");
  }
  refused(folder / "missing.g2");
  // A curve is no surface, but no error beside one.
  const std::string curve = "100 1 0 0\n3 0\n2 2\n0 0 1 1\n0 0 0\n1 1 1\n";
  broken(curve, "holds no surface; it holds: 1 spline curve");
  writeFile(folder / "both.g2", curve + good);
  Reading both;
  both.read(folder / "both.g2");
  EXPECT_TRUE(both.errors.empty());
  ASSERT_EQ(both.warnings.size(), 1u);
  EXPECT_NE(both.warnings[0].find("1 spline curve"), std::string::npos);
  EXPECT_STREQ(both.reader->GetNotRead(), "1 spline curve");
}

TEST(NURBSSurfaceReader, SharedG2Files)
{
  const std::string file = sharedFile("spline_surface_1.g2");
  if (file.empty())
  {
    GTEST_SKIP() << "needs BSV_SHARED_DATA";
  }
  Reading reading;
  reading.read(file);
  ASSERT_TRUE(reading.errors.empty());
  const NURBSSurface surface = reading.patches()[0].surface;
  EXPECT_EQ(surface.count(0), 18);
  EXPECT_EQ(surface.count(1), 17);
  EXPECT_EQ(surface.points[0], Vec3(23.9564155054104, 15.1533216458665, 14.7836780757033));
  checkTessellation(reading);
  EXPECT_NE(refused(sharedFile("trimmed_sfs.g2")).find("line 1: class 210"), std::string::npos);
}

#ifndef BSPLINEVOLUME_WITH_OPENCASCADE

TEST(NURBSSurfaceReader, CADFilesNeedOpenCASCADE)
{
  const TemporaryFolder folder;
  writeFile(folder / "a.step", "ISO-10303-21;\nEND-ISO-10303-21;\n");
  EXPECT_NE(refused(folder / "a.step").find("OpenCASCADE"), std::string::npos);
  EXPECT_EQ(vtkNURBSSurfaceReader::CanReadFile((folder / "a.step").c_str()), 0);
}

#else

namespace
{

/// Writes a shape and mutes the writers.
void writeShape(const TopoDS_Shape& shape, const std::string& fileName, const char* unit = "MM")
{
  Message::DefaultMessenger()->ChangePrinters().Clear();
  IGESControl_Controller::Init();
  if (fileName.find(".igs") != std::string::npos)
  {
    IGESControl_Writer writer(unit, 1);
    writer.AddShape(shape);
    writer.ComputeModel();
    ASSERT_TRUE(writer.Write(fileName.c_str()));
  }
  else if (fileName.find(".step") != std::string::npos)
  {
    Interface_Static::SetCVal("write.step.unit", unit);
    STEPControl_Writer writer;
    writer.Transfer(shape, STEPControl_AsIs);
    ASSERT_EQ(writer.Write(fileName.c_str()), IFSelect_RetDone);
  }
  else
  {
    ASSERT_TRUE(BRepTools::Write(shape, fileName.c_str()));
  }
}

double areaOf(const TopoDS_Shape& shape)
{
  GProp_GProps properties;
  BRepGProp::SurfaceProperties(shape, properties, 1e-9);
  return properties.Mass();
}

double areaOf(const std::vector<BodyPatch>& patches)
{
  double area = 0.0;
  for (const BodyPatch& patch : patches)
  {
    area += patchArea(patch);
  }
  return area;
}

/// Bodies of every elementary surface, trimmed by each other.
TopoDS_Shape primitives()
{
  BRep_Builder builder;
  TopoDS_Compound all;
  builder.MakeCompound(all);
  const gp_Ax2 axis(gp_Pnt(1, 2, 3), gp_Dir(1, 2, 2));
  builder.Add(all, BRepPrimAPI_MakeSphere(axis, 2.0).Shape());
  builder.Add(all, BRepPrimAPI_MakeTorus(axis, 9.0, 1.5).Shape());
  builder.Add(all, BRepPrimAPI_MakeCone(gp_Ax2(gp_Pnt(20, 0, 0), gp_Dir(0, 0, 1)), 3.0, 0.0, 4.0).Shape());
  builder.Add(all, BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(30, 0, 0), gp_Dir(0, 1, 0)), 2.0, 5.0, 2.0).Shape());
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(gp_Pnt(40, 0, 0), 4.0, 5.0, 6.0).Shape();
  const TopoDS_Shape drill = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(42, -1, 3), gp_Dir(0.2, 1, 0.1)), 1.0, 9.0).Shape();
  const TopoDS_Shape ball = BRepPrimAPI_MakeSphere(gp_Pnt(44, 5, 6), 1.7).Shape();
  builder.Add(all, BRepAlgoAPI_Cut(BRepAlgoAPI_Cut(box, drill).Shape(), ball).Shape());
  return all;
}

/// A face of a B-spline surface.
TopoDS_Shape splineFace(const NURBSSurface& s)
{
  TColgp_Array2OfPnt poles(1, s.count(0), 1, s.count(1));
  TColStd_Array2OfReal weights(1, s.count(0), 1, s.count(1));
  for (int j = 0; j < s.count(1); ++j)
  {
    for (int i = 0; i < s.count(0); ++i)
    {
      const std::size_t at = std::size_t(j) * s.count(0) + i;
      poles(i + 1, j + 1) = gp_Pnt(s.points[at][0], s.points[at][1], s.points[at][2]);
      weights(i + 1, j + 1) = s.rational() ? s.weights[at] : 1.0;
    }
  }
  std::vector<double> values[2];
  std::vector<int> counts[2];
  for (int d = 0; d < 2; ++d)
  {
    for (const double knot : s.knots[d])
    {
      if (values[d].empty() || values[d].back() != knot)
      {
        values[d].push_back(knot);
        counts[d].push_back(0);
      }
      ++counts[d].back();
    }
  }
  const auto reals = [](const std::vector<double>& v) {
    return TColStd_Array1OfReal(v[0], 1, static_cast<int>(v.size()));
  };
  const auto integers = [](const std::vector<int>& v) {
    return TColStd_Array1OfInteger(v[0], 1, static_cast<int>(v.size()));
  };
  Handle(Geom_BSplineSurface) surface = new Geom_BSplineSurface(poles, weights, reals(values[0]), reals(values[1]),
    integers(counts[0]), integers(counts[1]), s.degree[0], s.degree[1]);
  return BRepBuilderAPI_MakeFace(surface, 1e-7).Shape();
}

/// The B-spline surfaces (entity 128) of an IGES file, read from its text without any library.
std::vector<NURBSSurface> igesSurfaces(const std::string& fileName)
{
  std::ifstream stream(fileName);
  std::string line;
  std::string parameters;
  while (std::getline(stream, line))
  {
    if (line.size() > 72 && line[72] == 'P')
    {
      parameters += line.substr(0, 64);
    }
  }
  std::vector<NURBSSurface> surfaces;
  std::istringstream entities(parameters);
  for (std::string entity; std::getline(entities, entity, ';');)
  {
    std::istringstream fields(entity);
    std::vector<double> v;
    for (std::string field; std::getline(fields, field, ',');)
    {
      std::replace(field.begin(), field.end(), 'D', 'E');
      v.push_back(std::strtod(field.c_str(), nullptr));
    }
    if (v.empty() || v[0] != 128.0)
    {
      continue;
    }
    NURBSSurface s;
    const int n[2] = { static_cast<int>(v[1]) + 1, static_cast<int>(v[2]) + 1 };
    s.degree = { static_cast<int>(v[3]), static_cast<int>(v[4]) };
    std::size_t at = 10;
    for (int d = 0; d < 2; ++d)
    {
      s.knots[d].assign(v.begin() + at, v.begin() + at + n[d] + s.degree[d] + 1);
      at += n[d] + s.degree[d] + 1;
    }
    s.weights.assign(v.begin() + at, v.begin() + at + n[0] * n[1]);
    at += n[0] * n[1];
    for (int i = 0; i < n[0] * n[1]; ++i, at += 3)
    {
      s.points.emplace_back(v[at], v[at + 1], v[at + 2]);
    }
    surfaces.push_back(s);
  }
  return surfaces;
}

void expectSameBits(const std::vector<BodyPatch>& patches, const std::vector<NURBSSurface>& expected)
{
  ASSERT_EQ(patches.size(), expected.size());
  for (std::size_t i = 0; i < patches.size(); ++i)
  {
    const NURBSSurface& s = patches[i].surface;
    EXPECT_EQ(s.degree, expected[i].degree) << i;
    EXPECT_EQ(s.knots, expected[i].knots) << i;
    EXPECT_EQ(s.points, expected[i].points) << i;
    const bool equal = std::all_of(
      expected[i].weights.begin(), expected[i].weights.end(), [&](double w) { return w == expected[i].weights[0]; });
    EXPECT_EQ(s.weights, equal ? std::vector<double>() : expected[i].weights) << i;
  }
}

/// Our closest points against OpenCASCADE's extrema on its own shape, at points near the body and far from it.
void compareClosestPoints(const std::vector<BodyPatch>& patches, const TopoDS_Shape& shape, int count)
{
  const BodySurface body(patches);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  // Faces alone: points inside a solid have the distance zero from it.
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(shape, TopAbs_FACE, faces);
  BRep_Builder builder;
  TopoDS_Compound all;
  builder.MakeCompound(all);
  for (int f = 1; f <= faces.Extent(); ++f)
  {
    builder.Add(all, faces(f));
  }
  double farther = 0.0;
  double worstResidual = 0.0;
  for (int n = 0; n < count; ++n)
  {
    Vec3 query;
    for (int k = 0; k < 3; ++k)
    {
      query[k] = body.bounds().min()[k] + (1.2 * unit(random) - 0.1) * body.bounds().diagonal()[k];
    }
    const BodyPoint at = body.closestPoint(query);
    BRepExtrema_DistShapeShape other(BRepBuilderAPI_MakeVertex(gp_Pnt(query[0], query[1], query[2])).Vertex(), all);
    ASSERT_TRUE(other.IsDone());
    // Its edges are curves of their own, off the surface by up to their tolerance: that much does not count.
    double off = 1e300;
    for (int s = 1; s <= other.NbSolution(); ++s)
    {
      const gp_Pnt p = other.PointOnShape2(s);
      off = std::min(off, body.closestPoint({ p.X(), p.Y(), p.Z() }).distance);
    }
    farther = std::max(farther, (at.distance - other.Value() - off) / body.size());
    if (!at.onEdge)
    {
      const SurfaceDerivatives d = evaluate(patches[at.patch].surface, at.u, at.v);
      const Vec3 r = query - d.x;
      worstResidual = std::max({ worstResidual, std::abs(r.dot(d.u)) / std::max(d.u.norm(), 1e-300) / body.size(),
        std::abs(r.dot(d.v)) / std::max(d.v.norm(), 1e-300) / body.size() });
    }
  }
  std::cout << "closest points: farther than OpenCASCADE's by " << farther << " of the size, residual " << worstResidual
            << " of the size\n";
  EXPECT_LE(farther, 1e-9);
  EXPECT_LE(worstResidual, 1e-12);
}

} // namespace

TEST(NURBSSurfaceReader, PrimitivesBecomeNURBSExactly)
{
  const TemporaryFolder folder;
  const TopoDS_Shape shape = primitives();
  for (const char* name : { "all.brep", "all.step", "all.igs" })
  {
    SCOPED_TRACE(name);
    writeShape(shape, folder / name);
    Reading reading;
    reading.read(folder / name);
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    EXPECT_TRUE(reading.warnings.empty()) << reading.warnings[0];
    const std::vector<BodyPatch> patches = reading.patches();
    EXPECT_GT(reading.reader->GetNumberOfRationalPatches(), 4);
    EXPECT_NEAR(areaOf(patches) / areaOf(shape), 1.0, 1e-7);
    checkTessellation(reading);
  }
  // The sphere is one.
  Reading reading;
  reading.read(folder / "all.brep");
  const std::vector<BodyPatch> patches = reading.patches();
  const BodySurface ball({ patches[0] });
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-4.0, 4.0);
  for (int n = 0; n < 300; ++n)
  {
    const Vec3 center(1, 2, 3);
    const Vec3 query = center + Vec3(place(random), place(random), place(random));
    const BodyPoint at = ball.closestPoint(query);
    EXPECT_NEAR(at.distance, std::abs((query - center).norm() - 2.0), 1e-13);
    EXPECT_NEAR(at.geometry.normal.dot((query - center).normalized()), 1.0, 1e-12);
  }
  compareClosestPoints(patches, shape, 150);
}

TEST(NURBSSurfaceReader, SplinesKeepEveryBit)
{
  const TemporaryFolder folder;
  NURBSSurface surface = bumpy(5, { 3, 4 }, { 4, 3 }, 0.4, true);
  // A knot of multiplicity degree must not split the surface.
  NURBSSurface kinked = bumpy(6, { 2, 3 }, { 4, 3 }, 0.4, false);
  kinked.knots[0][4] = kinked.knots[0][3];
  BRep_Builder builder;
  TopoDS_Compound both;
  builder.MakeCompound(both);
  builder.Add(both, splineFace(surface));
  builder.Add(both, splineFace(kinked));
  for (const char* unit : { "MM", "M", "INCH" })
  {
    SCOPED_TRACE(unit);
    writeShape(both, folder / "splines.igs", unit);
    Reading reading;
    reading.read(folder / "splines.igs");
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    expectSameBits(reading.patches(), igesSurfaces(folder / "splines.igs"));
    EXPECT_EQ(reading.reader->GetNumberOfTrimmedPatches(), 0);
    // In metres all files say the same, whatever their unit.
    Reading metres;
    metres.reader->SetLengthUnit(vtkNURBSSurfaceReader::METRE);
    metres.read(folder / "splines.igs");
    EXPECT_LE((metres.patches()[0].surface.points[7] - surface.points[7] / 1000.0).norm(), 1e-12);
  }
  // OpenCASCADE's own format holds all digits.
  writeShape(both, folder / "splines.brep");
  Reading reading;
  reading.read(folder / "splines.brep");
  expectSameBits(reading.patches(), { surface, kinked });
  EXPECT_EQ(smoothPieces(reading.patches()[1].surface).size(), 2u);
}

TEST(NURBSSurfaceReader, TextsOfAnyProgram)
{
  const TemporaryFolder folder;
  const std::string mark = "\xef\xbb\xbf";
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    {
      text.replace(at, from.size(), to);
    }
    return text;
  };
  writeShape(BRepPrimAPI_MakeCylinder(2.0, 3.0).Shape(), folder / "plain.step");
  writeShape(BRepPrimAPI_MakeCylinder(2.0, 3.0).Shape(), folder / "plain.igs");
  writeShape(BRepPrimAPI_MakeCylinder(2.0, 3.0).Shape(), folder / "plain.brep");
  for (const std::string format : { "step", "igs", "brep" })
  {
    Reading plain;
    plain.read(folder / ("plain." + format));
    ASSERT_TRUE(plain.errors.empty()) << plain.errors[0];
    const std::string text = readFile(folder / ("plain." + format));
    std::vector<std::string> texts{ replaced(text, "\n", "\r\n"), mark + text, "\n\n" + text };
    if (format != "brep")
    {
      texts.push_back(replaced(text, "\n", "\r"));
    }
    if (format == "step")
    {
      std::string lower = text;
      std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
      texts.push_back(lower);
      texts.push_back(replaced(text, " ", "\t"));
      texts.push_back("/* by hand */ " + replaced(text, "\n", " "));
    }
    if (format == "igs")
    {
      std::string lower = text;
      std::string glued;
      for (std::size_t at = 0; at < text.size(); at += 81)
      {
        lower[at + 72] = static_cast<char>(std::tolower(text[at + 72]));
        glued += text.substr(at, 80);
      }
      texts.push_back(lower);
      texts.push_back(glued);
    }
    for (const std::string& other : texts)
    {
      SCOPED_TRACE(format + " " + std::to_string(&other - texts.data()));
      writeFile(folder / ("other." + format), other);
      EXPECT_EQ(vtkNURBSSurfaceReader::CanReadFile((folder / ("other." + format)).c_str()), 1);
      Reading reading;
      reading.read(folder / ("other." + format));
      ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
      std::vector<NURBSSurface> surfaces;
      for (const BodyPatch& patch : plain.patches())
      {
        surfaces.push_back(patch.surface);
      }
      expectSameBits(reading.patches(), surfaces);
    }
  }
  writeFile(folder / "marked.g2", mark + g2(bumpy(5, { 3, 4 }, { 4, 3 }, 0.4, true)));
  Reading marked;
  marked.read(folder / "marked.g2");
  EXPECT_TRUE(marked.errors.empty()) << marked.errors[0];

  // What is packed or in another form says so.
  writeFile(folder / "packed.stpz", "PK\x03\x04 and more");
  EXPECT_NE(refused(folder / "packed.stpz").find("zip archive"), std::string::npos);
  writeFile(folder / "form.igs", std::string(72, ' ') + "C      1\n");
  EXPECT_NE(refused(folder / "form.igs").find("compressed form"), std::string::npos);
}

namespace
{

/// A part that is turned and shifted.
TopoDS_Shape placed(const TopoDS_Shape& shape, double turn, const gp_Vec& shift)
{
  gp_Trsf rotation;
  rotation.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 3)), turn);
  gp_Trsf translation;
  translation.SetTranslation(shift);
  return shape.Moved(TopLoc_Location(translation * rotation));
}

TopoDS_Shape compound(const std::vector<TopoDS_Shape>& shapes)
{
  BRep_Builder builder;
  TopoDS_Compound all;
  builder.MakeCompound(all);
  for (const TopoDS_Shape& shape : shapes)
  {
    builder.Add(all, shape);
  }
  return all;
}

/// Two instances of a torus, one of them in an assembly within the assembly, and a box.
struct Assembly
{
  TopoDS_Shape torus = BRepPrimAPI_MakeTorus(3.0, 1.0).Shape();
  TopoDS_Shape box = BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape();
  TopoDS_Shape outerTorus = placed(this->torus, 1.0, gp_Vec(0, 20, 0));
  TopoDS_Shape innerTorus = placed(this->torus, 0.5, gp_Vec(10, 0, 0));

  static TopoDS_Shape inside(const TopoDS_Shape& shape) { return placed(shape, -0.7, gp_Vec(0, 0, 30)); }
  TopoDS_Shape all() const { return compound({ this->outerTorus, inside(compound({ this->innerTorus, this->box })) }); }
};

void writeAssembly(const TopoDS_Shape& shape, const std::string& fileName, const char* unit = "MM")
{
  Interface_Static::SetIVal("write.step.assembly", 1);
  writeShape(shape, fileName, unit);
  Interface_Static::SetIVal("write.step.assembly", 0);
}

/// The numbers of all STEP entities that begin so.
std::vector<std::string> entitiesOf(const std::string& text, const std::string& begin)
{
  std::vector<std::string> numbers;
  for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at + 1))
  {
    const std::size_t sharp = text.rfind('#', at);
    numbers.push_back(text.substr(sharp, text.find_first_of(" =", sharp) - sharp));
  }
  return numbers;
}

/// The text with more entities.
std::string withEntities(const std::string& text, const std::string& entities)
{
  const std::size_t end = text.rfind("ENDSEC;");
  return text.substr(0, end) + entities + text.substr(end);
}

} // namespace

TEST(NURBSSurfaceReader, AssembliesAreInTheirPlaces)
{
  const TemporaryFolder folder;
  const TopoDS_Shape all = Assembly().all();
  for (const char* unit : { "MM", "INCH", "M" })
  {
    SCOPED_TRACE(unit);
    writeAssembly(all, folder / "assembly.step", unit);
    Reading reading;
    reading.reader->SetLengthUnit(vtkNURBSSurfaceReader::MILLIMETRE);
    reading.read(folder / "assembly.step");
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    EXPECT_TRUE(reading.warnings.empty()) << reading.warnings[0];
    EXPECT_EQ(reading.reader->GetNumberOfPatches(), 1 + 1 + 6);
    compareClosestPoints(reading.patches(), all, 40);
  }
}

// Parts, faces, layers, and single places of a part that an assembly hides.
TEST(NURBSSurfaceReader, HiddenPartsOfSTEPAreLeftOut)
{
  const TemporaryFolder folder;
  const Assembly assembly;
  writeAssembly(assembly.all(), folder / "all.step");
  const std::string text = readFile(folder / "all.step");
  const std::string style = "#9001=SURFACE_STYLE_USAGE(.BOTH.,#9002);#9002=SURFACE_SIDE_STYLE('',());"
                            "#9003=PRESENTATION_STYLE_ASSIGNMENT((#9001));";
  const auto expectLeft = [&](const std::string& entities, const TopoDS_Shape& left) {
    SCOPED_TRACE(entities);
    writeFile(folder / "hidden.step", withEntities(text, style + entities + "\n"));
    Reading reading;
    reading.read(folder / "hidden.step");
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    TopTools_IndexedMapOfShape faces;
    TopExp::MapShapes(left, TopAbs_FACE, faces);
    ASSERT_EQ(reading.reader->GetNumberOfPatches(), faces.Extent());
    const int hidden = 8 - faces.Extent();
    EXPECT_EQ(std::string(reading.reader->GetNotRead()),
      hidden == 0 ? "" : std::to_string(hidden) + " hidden (blanked) surface");
    compareClosestPoints(reading.patches(), left, 10);
  };
  const std::vector<std::string> solids = entitiesOf(text, "MANIFOLD_SOLID_BREP(");
  const std::vector<std::string> faces = entitiesOf(text, "ADVANCED_FACE(");
  ASSERT_EQ(solids.size(), 2u);
  ASSERT_EQ(faces.size(), 7u);
  const bool torusFirst = text.find("TOROIDAL_SURFACE") < text.find("PLANE(");
  const std::string torus = solids[torusFirst ? 0 : 1];
  const std::string torusFace = torusFirst ? faces.front() : faces.back();
  const TopoDS_Shape noTorus = Assembly::inside(assembly.box);
  for (const std::string& item : { torus, torusFace })
  {
    expectLeft("#9004=STYLED_ITEM('',(#9003)," + item + ");#9005=INVISIBILITY((#9004));", noTorus);
  }
  expectLeft("#9004=PRESENTATION_LAYER_ASSIGNMENT('off','',(" + torus + "));#9005=INVISIBILITY((#9004));", noTorus);

  const std::string axes = entitiesOf(text, "AXIS2_PLACEMENT_3D(").at(0);
  const std::string context = entitiesOf(text, "GEOMETRIC_REPRESENTATION_CONTEXT(3)").at(0);
  // A style in the context of a placement hides what is placed there alone.
  const auto hiddenAt = [&](const std::string& item, const std::string& placement) {
    return "#9004=STYLED_ITEM('',(#9003)," + item + ");#9005=INVISIBILITY((#9006));" +
      "#9006=OVER_RIDING_STYLED_ITEM('',(#9007)," + item + ",#9004);" +
      "#9007=PRESENTATION_STYLE_BY_CONTEXT((#9001),#9008);#9008=SHAPE_REPRESENTATION('',(" + axes + ")," + context +
      ");#9009=SHAPE_DEFINITION_REPRESENTATION(" + placement + ",#9008);";
  };
  const TopoDS_Shape noOuter = Assembly::inside(compound({ assembly.innerTorus, assembly.box }));
  const TopoDS_Shape noInner = compound({ assembly.outerTorus, noTorus });
  const std::vector<std::string> placements = entitiesOf(text, "PRODUCT_DEFINITION_SHAPE('Placement'");
  ASSERT_EQ(placements.size(), 4u);
  int without[3] = { 0, 0, 0 };
  for (const std::string& placement : placements)
  {
    writeFile(folder / "hidden.step", withEntities(text, style + hiddenAt(torus, placement)));
    Reading reading;
    reading.read(folder / "hidden.step");
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    const bool none = reading.reader->GetNumberOfPatches() == 8;
    const Vec3 center(0, 20, 0);
    const bool outer = BodySurface(reading.patches()).closestPoint(center).distance < 5.0;
    ++without[none ? 0 : outer ? 1 : 2];
    expectLeft(hiddenAt(torus, placement), none ? assembly.all() : outer ? noInner : noOuter);
  }
  // The box has no torus; the torus outside; the assembly within the assembly, and the torus in it.
  EXPECT_EQ(without[0], 1);
  EXPECT_EQ(without[2], 1);
  EXPECT_EQ(without[1], 2);
}

// Solids, shells and faces, also in a group that is not hidden.
TEST(NURBSSurfaceReader, HiddenPartsOfIGESAreLeftOut)
{
  const TemporaryFolder folder;
  const TopoDS_Shape boxes[2] = { BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(),
    BRepPrimAPI_MakeBox(gp_Pnt(5, 0, 0), 1.0, 1.0, 1.0).Shape() };
  writeShape(compound({ boxes[0], boxes[1] }), folder / "all.igs");
  const std::string text = readFile(folder / "all.igs");
  for (const auto& [type, hidden] : { std::pair("186", 6), std::pair("514", 6), std::pair("510", 1) })
  {
    SCOPED_TRACE(type);
    // The first card of the first entity of the type; its blank status.
    std::string changed = text;
    const std::size_t card = text.find(std::string("\n     ") + type) + 1;
    ASSERT_NE(card, std::string::npos + 1);
    changed.replace(card + 64, 2, "01");
    writeFile(folder / "hidden.igs", changed);
    Reading reading;
    reading.read(folder / "hidden.igs");
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    EXPECT_EQ(reading.reader->GetNumberOfPatches(), 12 - hidden);
    EXPECT_EQ(std::string(reading.reader->GetNotRead()), std::to_string(hidden) + " hidden (blanked) surface");
    if (hidden == 6)
    {
      const bool first = BodySurface(reading.patches()).closestPoint({ 0, 0, 0 }).distance < 1.0;
      compareClosestPoints(reading.patches(), boxes[first ? 0 : 1], 10);
    }
  }
}

TEST(NURBSSurfaceReader, WhatIsNoSurfaceIsCounted)
{
  const TemporaryFolder folder;
  BRep_Builder builder;
  TopoDS_Compound mixed;
  builder.MakeCompound(mixed);
  builder.Add(mixed, BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape());
  builder.Add(mixed, BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 9), gp_Pnt(1, 0, 9)).Shape());
  builder.Add(mixed, BRepBuilderAPI_MakeVertex(gp_Pnt(0, 0, 11)).Shape());
  for (const char* name : { "mixed.brep", "mixed.igs" })
  {
    SCOPED_TRACE(name);
    writeShape(mixed, folder / name);
    Reading reading;
    reading.read(folder / name);
    ASSERT_TRUE(reading.errors.empty());
    EXPECT_EQ(reading.reader->GetNumberOfPatches(), 6);
    EXPECT_EQ(reading.reader->GetNumberOfTrimmedPatches(), 0);
    ASSERT_EQ(reading.warnings.size(), 1u);
    EXPECT_NE(std::string(reading.reader->GetNotRead()).find("1 curve without a face"), std::string::npos)
      << reading.reader->GetNotRead();
    EXPECT_NE(std::string(reading.reader->GetNotRead()).find("1 point without a face"), std::string::npos)
      << reading.reader->GetNotRead();
  }
  TopoDS_Compound curve;
  builder.MakeCompound(curve);
  builder.Add(curve, BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 9), gp_Pnt(1, 0, 9)).Shape());
  writeShape(curve, folder / "curve.brep");
  EXPECT_NE(refused(folder / "curve.brep").find("holds no surface; it holds: 1 curve"), std::string::npos);
}

TEST(NURBSSurfaceReader, TruncatedCADFilesAreRefused)
{
  const TemporaryFolder folder;
  const TopoDS_Shape shape = primitives();
  for (const std::string name : { "all.brep", "all.step", "all.igs" })
  {
    SCOPED_TRACE(name);
    writeShape(shape, folder / name);
    const std::string text = readFile(folder / name);
    for (int n = 1; n < 20; ++n)
    {
      const std::string cut = folder / ("cut" + std::to_string(n) + name);
      writeFile(cut, text.substr(0, text.size() * n / 20));
      refused(cut);
    }
    // The last line alone is missing.
    const std::string cut = folder / ("last" + name);
    writeFile(cut, text.substr(0, text.find_last_not_of("\n\r ", text.size() - 1) - 3));
    refused(cut);
    // The middle is missing, or another file's.
    writeFile(cut, text.substr(0, text.size() / 3) + text.substr(text.size() / 2));
    Reading reading;
    reading.read(cut);
    EXPECT_EQ(reading.errors.size(), 1u);
    EXPECT_EQ(reading.output->GetNumberOfPartitionedDataSets(), 0u);
  }
}

TEST(NURBSSurfaceReader, DamagedEntitiesAreRefused)
{
  const TemporaryFolder folder;
  writeShape(primitives(), folder / "all.step");
  const std::string text = readFile(folder / "all.step");
  Reading whole;
  whole.read(folder / "all.step");
  const std::vector<BodyPatch> patches = whole.patches();
  // Every entity that is a point for one that is unknown, then for one of another kind; one reference to nowhere.
  int refusals = 0;
  for (const std::string other : { "CARTESIAN_PAINT", "DIRECTION" })
  {
    std::size_t at = text.find("CARTESIAN_POINT(");
    for (int n = 0; n < 12 && at != std::string::npos; ++n)
    {
      writeFile(folder / "bad.step", std::string(text).replace(at, 15, other));
      Reading reading;
      reading.read(folder / "bad.step");
      refusals += !reading.errors.empty();
      if (reading.errors.empty())
      {
        // No face depends on it.
        const std::vector<BodyPatch> left = reading.patches();
        ASSERT_EQ(left.size(), patches.size());
        for (std::size_t p = 0; p < patches.size(); ++p)
        {
          EXPECT_EQ(left[p].surface.points, patches[p].surface.points);
        }
        EXPECT_STRNE(reading.reader->GetNotRead(), "");
      }
      at = text.find("CARTESIAN_POINT(", at + text.size() / 15);
    }
  }
  EXPECT_GE(refusals, 20);
  // The bounds of a face.
  const std::size_t reference = text.find("(#", text.find("ADVANCED_FACE("));
  writeFile(folder / "bad.step", std::string(text).replace(reference + 2, 1, "99999"));
  EXPECT_NE(refused(folder / "bad.step").find("is used but nowhere defined"), std::string::npos);
}

TEST(NURBSSurfaceReader, WhatNoFaceDependsOnNeverRefusesSTEP)
{
  const TemporaryFolder folder;
  writeShape(primitives(), folder / "all.step");
  const std::string text = readFile(folder / "all.step");
  Reading whole;
  whole.read(folder / "all.step");
  const std::string end = "ENDSEC;\nEND-ISO-10303-21;";
  ASSERT_NE(text.find(end), std::string::npos);
  struct Kind
  {
    const char* entities;
    const char* keyword;
  };
  for (const Kind& kind : {
         Kind{ "#9001=CURVE_STYLE('',$,$,$);", "CurveStyle" },
         Kind{ "#9001=PERSON('1');", "Person" },
         Kind{ "#9001=COLOUR_RGB('',0.1);", "ColourRgb" },
         Kind{ "#9001=POINT_STYLE('',#9002,$,$);", "POINT_STYLE" },
         Kind{ "#9001=CALENDAR_DATE(1,2);", "CalendarDate" },
         Kind{ "#9001=TEXT_LITERAL('note');", "" },
         Kind{ "#9001=SURFACE_STYLE_USAGE(.BOTH.,#9999);", "SURFACE_STYLE_USAGE" },
       })
  {
    writeFile(folder / "more.step", std::string(text).replace(text.find(end), 0, std::string(kind.entities) + "\n"));
    Reading reading;
    reading.read(folder / "more.step");
    EXPECT_TRUE(reading.errors.empty()) << kind.entities << reading.errors[0];
    EXPECT_EQ(reading.reader->GetNumberOfPatches(), whole.reader->GetNumberOfPatches()) << kind.entities;
    const std::string notRead = reading.reader->GetNotRead();
    EXPECT_NE(notRead.find(kind.keyword), std::string::npos) << kind.entities << ": " << notRead;
  }
}

namespace
{

/// Card of an IGES file.
std::string card(std::string text, char section, int number)
{
  char end[16];
  std::snprintf(end, sizeof(end), "%c%7d", section, number);
  text.resize(72, ' ');
  return text + end + "\n";
}

/// An entity of an IGES file: type, parameters, and the columns for blank status and colour.
struct IGESEntity
{
  int type;
  std::string parameters;
  bool hidden = false;
  int colour = 0;
};

std::string igesFile(const std::vector<IGESEntity>& entities)
{
  std::string directory;
  std::string parameters;
  int card72 = 0;
  for (std::size_t e = 0; e < entities.size(); ++e)
  {
    const IGESEntity& entity = entities[e];
    const int first = card72 + 1;
    for (std::size_t at = 0; at < entity.parameters.size(); at += 60)
    {
      char back[16];
      std::snprintf(back, sizeof(back), "%8d", static_cast<int>(2 * e + 1));
      std::string line = entity.parameters.substr(at, 60);
      line.resize(64, ' ');
      parameters += card(line + back, 'P', ++card72);
    }
    char text[100];
    std::snprintf(text, sizeof(text), "%8d%8d%8d%8d%8d%8d%8d%8d%s", entity.type, first, 0, 0, 0, 0, 0, 0,
      entity.hidden ? "01000000" : "00000000");
    directory += card(text, 'D', static_cast<int>(2 * e + 1));
    std::snprintf(text, sizeof(text), "%8d%8d%8d%8d%8d", entity.type, 0, entity.colour, card72 - first + 1, 0);
    directory += card(text, 'D', static_cast<int>(2 * e + 2));
  }
  const std::string start = card("test", 'S', 1);
  const std::string global =
    card("1H,,1H;,4Htest,8Htest.igs,4Htest,4Htest,32,38,6,308,15,4Htest,1.0,2,2HMM,1,", 'G', 1) +
    card("1.0,15H20000101.000000,1.0E-6,1000.0,4Htest,4Htest,11,0;", 'G', 2);
  char end[64];
  std::snprintf(end, sizeof(end), "S%7dG%7dD%7dP%7d", 1, 2, static_cast<int>(2 * entities.size()), card72);
  return start + global + directory + parameters + card(end, 'T', 1);
}

/// A flat B-spline surface of 2 x 2 points. @param knots of the first direction
std::string plate(const std::string& knots, double height, const std::string& domain = ",0.,1.,0.,1.")
{
  const std::string z = "," + std::to_string(height);
  return "128,1,1,1,1,0,0,1,0,0," + knots + ",0.,0.,1.,1.,1.,1.,1.,1.,0.,0." + z + ",1.,0." + z + ",0.,1." + z +
    ",1.,1." + z + domain + ";";
}

/// The four sides of a rectangle at z = height, as lines in the order of a loop.
std::vector<IGESEntity> rectangle(double x0, double x1, double y0, double y1, double height = 0.0)
{
  const std::array<std::array<double, 2>, 5> corners{ { { x0, y0 }, { x1, y0 }, { x1, y1 }, { x0, y1 }, { x0, y0 } } };
  std::vector<IGESEntity> sides;
  for (int s = 0; s < 4; ++s)
  {
    std::string text = "110";
    for (const auto& corner : { corners[s], corners[s + 1] })
    {
      text += "," + std::to_string(corner[0]) + "," + std::to_string(corner[1]) + "," + std::to_string(height);
    }
    sides.push_back({ 110, text + ";" });
  }
  return sides;
}

/// A plate, trimmed by loops: entities 144, 142 and 102.
std::vector<IGESEntity> trimmedPlate(const std::vector<std::vector<IGESEntity>>& loops)
{
  std::vector<IGESEntity> entities{ { 128, plate("0.,0.,1.,1.", 0.0) } };
  const auto number = [&] { return std::to_string(2 * entities.size() + 1); };
  std::string pointers;
  for (const std::vector<IGESEntity>& sides : loops)
  {
    std::string curve = "102," + std::to_string(sides.size());
    for (const IGESEntity& side : sides)
    {
      curve += "," + number();
      entities.push_back(side);
    }
    const std::string composite = number();
    entities.push_back({ 102, curve + ";" });
    pointers += "," + number();
    entities.push_back({ 142, "142,0,1,0," + composite + ",2;" });
  }
  entities.push_back({ 144, "144,1,1," + std::to_string(loops.size() - 1) + pointers + ";" });
  return entities;
}

} // namespace

TEST(NURBSSurfaceReader, SurfacesOfIGESAreTheRightOnes)
{
  const TemporaryFolder folder;
  const double pi = std::acos(-1.0);
  const std::string line = "110,1.,0.,0.,1.,0.,2.;"; // x = 1, along z
  const std::string axis = "110,0.,0.,0.,0.,0.,1.;";
  const std::string quarter = "100,0.,0.,0.,1.,0.,0.,1.;"; // of the unit circle
  const std::string larger = "100,3.,0.,0.,2.,0.,0.,2.;";
  struct Kind
  {
    const char* what;
    std::vector<IGESEntity> entities;
    double area;
  };
  std::vector<IGESEntity> bounded{ { 128, plate("0.,0.,1.,1.", 0.0) } };
  for (const IGESEntity& side : rectangle(0.25, 0.75, 0.25, 0.5))
  {
    bounded.push_back(side);
  }
  bounded.push_back({ 141, "141,0,0,1,4,3,1,0,5,1,0,7,1,0,9,1,0;" });
  bounded.push_back({ 143, "143,0,1,1,11;" });
  const std::vector<Kind> kinds = {
    { "ruled between lines",
      { { 110, "110,0.,0.,0.,1.,0.,0.;" }, { 110, "110,0.,1.,0.,1.,1.,0.;" }, { 118, "118,1,3,0,0;" } }, 1.0 },
    { "ruled, one backwards",
      { { 110, "110,0.,0.,0.,1.,0.,0.;" }, { 110, "110,1.,1.,0.,0.,1.,0.;" }, { 118, "118,1,3,1,0;" } }, 1.0 },
    // A quarter of a cone between circles of radius 1 and 2, 3 apart.
    { "ruled between arcs", { { 100, quarter }, { 100, larger }, { 118, "118,1,3,0,0;" } },
      pi / 4 * 3 * std::sqrt(10.0) },
    { "revolution", { { 110, axis }, { 110, line }, { 120, "120,1,3,0.,6.283185307179586;" } }, 4 * pi },
    { "part of a revolution",
      { { 110, axis }, { 110, line }, { 120, "120,1,3,1.5707963267948966,3.141592653589793;" } }, pi },
    { "tabulated cylinder", { { 100, quarter }, { 122, "122,1,1.,0.,3.;" } }, 1.5 * pi },
    { "bounded", bounded, 0.125 },
    { "trimmed", trimmedPlate({ rectangle(0.25, 0.75, 0.25, 0.5) }), 0.125 },
    { "trimmed with a hole", trimmedPlate({ rectangle(0.0, 1.0, 0.0, 1.0), rectangle(0.25, 0.75, 0.25, 0.5) }), 0.875 },
  };
  for (const Kind& kind : kinds)
  {
    SCOPED_TRACE(kind.what);
    writeFile(folder / "a.igs", igesFile(kind.entities));
    Reading reading;
    reading.read(folder / "a.igs");
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    EXPECT_TRUE(reading.warnings.empty()) << reading.warnings[0];
    ASSERT_EQ(reading.reader->GetNumberOfPatches(), 1);
    EXPECT_NEAR(areaOf(reading.patches()), kind.area, 1e-6 * kind.area);
  }
}

TEST(NURBSSurfaceReader, SurfacesThatBecomeNoFaceAreNamed)
{
  const TemporaryFolder folder;
  const std::string knots = "0.,0.,1.,1.";
  // From a line to a point, which OpenCASCADE leaves out without a word.
  writeFile(folder / "a.igs",
    igesFile({ { 128, plate(knots, 0.0) }, { 110, "110,0.,0.,5.,1.,0.,5.;" }, { 116, "116,0.,1.,5.,0;" },
      { 118, "118,3,5,0,0;" } }));
  std::string error = refused(folder / "a.igs");
  EXPECT_NE(error.find("surface D7 (type 118 (IGESGeom_RuledSurface)) cannot be converted"), std::string::npos)
    << error;
  // A loop that is elsewhere.
  writeFile(folder / "b.igs", igesFile(trimmedPlate({ rectangle(10.0, 11.0, 10.0, 11.0) })));
  error = refused(folder / "b.igs");
  EXPECT_NE(error.find("face 1 cannot be cut out of its surface"), std::string::npos) << error;

  // Of STEP files the rest is read.
  const std::string head = "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n"
                           "FILE_NAME('t','2026-01-01T00:00:00',(''),(''),'','','');\n"
                           "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
                           "#1=APPLICATION_CONTEXT('a');\n#3=PRODUCT_CONTEXT('',#1,'mechanical');\n"
                           "#4=PRODUCT('p','p','',(#3));\n#5=PRODUCT_DEFINITION_FORMATION('','',#4);\n"
                           "#6=PRODUCT_DEFINITION_CONTEXT('part definition',#1,'design');\n"
                           "#7=PRODUCT_DEFINITION('d','',#5,#6);\n#8=PRODUCT_DEFINITION_SHAPE('','',#7);\n"
                           "#9=SHAPE_DEFINITION_REPRESENTATION(#8,#20);\n"
                           "#10=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n"
                           "#11=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));\n"
                           "#12=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());\n"
                           "#14=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#10,#11,#12))"
                           "REPRESENTATION_CONTEXT('',''));\n"
                           "#15=CARTESIAN_POINT('',(0.,0.,0.));\n#16=DIRECTION('',(0.,0.,1.));\n"
                           "#17=DIRECTION('',(1.,0.,0.));\n#18=AXIS2_PLACEMENT_3D('',#15,#16,#17);\n"
                           "#20=GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION('',(#18,#21),#14);\n";
  writeFile(folder / "c.step",
    head +
      "#21=GEOMETRIC_SET('',(#31,#32));\n#30=PLANE('',#18);\n"
      "#31=RECTANGULAR_TRIMMED_SURFACE('',#30,1.,3.,1.,2.,.T.,.T.);\n#32=SPHERICAL_SURFACE('',#18,1.);\n"
      "ENDSEC;\nEND-ISO-10303-21;\n");
  Reading reading;
  reading.read(folder / "c.step");
  ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
  EXPECT_EQ(reading.reader->GetNumberOfPatches(), 1);
  EXPECT_NEAR(areaOf(reading.patches()), 2.0, 1e-9);
  EXPECT_EQ(std::string(reading.reader->GetNotRead()), "1 StepGeom_SphericalSurface that is not converted to a face");
}

TEST(NURBSSurfaceReader, HabitsOfIGES)
{
  const TemporaryFolder folder;
  const std::string knots = "0.,0.,1.,1.";
  // Hidden surfaces are left out and counted.
  writeFile(folder / "a.igs", igesFile({ { 128, plate(knots, 0.0) }, { 128, plate(knots, 1.0), true } }));
  Reading hidden;
  hidden.read(folder / "a.igs");
  ASSERT_TRUE(hidden.errors.empty()) << hidden.errors[0];
  EXPECT_EQ(hidden.reader->GetNumberOfPatches(), 1);
  EXPECT_NE(std::string(hidden.reader->GetNotRead()).find("1 hidden"), std::string::npos)
    << hidden.reader->GetNotRead();
  // All of them: nothing is left, and the error says why.
  writeFile(folder / "b.igs", igesFile({ { 128, plate(knots, 0.0), true } }));
  EXPECT_NE(refused(folder / "b.igs").find("1 hidden"), std::string::npos);
  // Knots say the domain as well.
  writeFile(folder / "c.igs", igesFile({ { 128, plate(knots, 0.0, "") } }));
  Reading domain;
  domain.read(folder / "c.igs");
  ASSERT_TRUE(domain.errors.empty()) << domain.errors[0];
  ASSERT_EQ(domain.patches().size(), 1u);
  EXPECT_EQ(domain.patches()[0].surface.last(0), 1.0);
  checkTessellation(domain);
  // They must not decrease.
  writeFile(folder / "d.igs", igesFile({ { 128, plate("0.,0.5,0.25,1.", 0.0) } }));
  const std::string error = refused(folder / "d.igs");
  EXPECT_NE(error.find("surface D1: the knots of u decrease"), std::string::npos) << error;
  // Colours and notes that are wrong do not matter.
  for (const IGESEntity& other : { IGESEntity{ 314, "314,10.0;" }, IGESEntity{ 212, "212,1,5,x,1.0;" },
         IGESEntity{ 406, "406,2,x;" }, IGESEntity{ 410, "410,1;" } })
  {
    writeFile(folder / "e.igs", igesFile({ { 128, plate(knots, 0.0) }, other }));
    Reading reading;
    reading.read(folder / "e.igs");
    EXPECT_TRUE(reading.errors.empty()) << other.type << reading.errors[0];
    EXPECT_EQ(reading.reader->GetNumberOfPatches(), 1) << other.type;
  }
}

TEST(NURBSSurfaceReader, SharedCADFiles)
{
  struct Case
  {
    const char* name;
    int patches;
    int trimmed;
    double unit;
  };
  for (const Case& known :
    { Case{ "onera_m6_machaero.igs", 10, 0, 1.0 }, { "nacelle.stp", 6, 0, 1e-3 }, { "hammer.iges", 45, 45, 1e-3 },
      { "screw.step", 10, 8, 1e-3 }, { "export_D150WithGuides_wing.igs", 8, 2, 1e-3 } })
  {
    SCOPED_TRACE(known.name);
    const std::string file = sharedFile(known.name);
    if (file.empty())
    {
      GTEST_SKIP() << "needs BSV_SHARED_DATA";
    }
    Reading reading;
    reading.read(file);
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    EXPECT_EQ(reading.reader->GetNumberOfPatches(), known.patches);
    EXPECT_EQ(reading.reader->GetNumberOfTrimmedPatches(), known.trimmed);
    EXPECT_STREQ(reading.reader->GetDeclaredUnit(), known.unit == 1.0 ? "metre" : "millimetre");
    checkTessellation(reading);
    if (std::string(known.name).find(".ig") != std::string::npos)
    {
      // The last two faces of the wing lie on planes.
      std::vector<BodyPatch> splines = reading.patches();
      const std::vector<NURBSSurface> expected = igesSurfaces(file);
      splines.resize(std::min(splines.size(), expected.size()));
      expectSameBits(splines, expected);
    }
  }
}

TEST(NURBSSurfaceReader, AircraftIsComplete)
{
  const std::string file = sharedFile("export_D150WithGuides_fusedAircraft.brep");
  if (file.empty())
  {
    GTEST_SKIP() << "needs BSV_SHARED_DATA";
  }
  Reading reading;
  reading.read(file);
  ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
  const std::vector<BodyPatch> patches = reading.patches();
  TopoDS_Shape shape;
  BRep_Builder builder;
  ASSERT_TRUE(BRepTools::Read(shape, file.c_str(), builder));
  const double area = areaOf(patches);
  std::cout << "area " << area << ", relative difference to OpenCASCADE's " << area / areaOf(shape) - 1.0 << "\n";
  EXPECT_NEAR(area / areaOf(shape), 1.0, 1e-6);
  checkTessellation(reading);

  const BodySurface body(patches);
  std::vector<TrimRegion> regions;
  for (const BodyPatch& patch : patches)
  {
    regions.emplace_back(patch.loops);
  }
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Vec3> queries(100000);
  for (Vec3& query : queries)
  {
    const int p = static_cast<int>(random() % patches.size());
    const NURBSSurface& surface = patches[p].surface;
    const double u = surface.first(0) + unit(random) * (surface.last(0) - surface.first(0));
    const double v = surface.first(1) + unit(random) * (surface.last(1) - surface.first(1));
    query = evaluate(surface, u, v).x;
    for (int k = 0; k < 3; ++k)
    {
      query[k] += 0.02 * body.size() * (unit(random) - 0.5);
    }
  }
  const std::vector<BodyPoint> found = body.closestPoints(queries);
  int outliers = 0;
  int trimmed = 0;
  for (std::size_t i = 0; i < queries.size(); ++i)
  {
    const BodyPoint& at = found[i];
    const bool inside = regions[at.patch].contains({ at.u, at.v });
    trimmed += !patches[at.patch].loops.empty();
    if (!inside && (!at.onEdge || body.closestEdgePoint(at.geometry.point).distance > 1e-12 * body.size()))
    {
      ++outliers;
    }
  }
  std::cout << queries.size() << " closest points, " << trimmed << " of them on trimmed patches, " << outliers
            << " beyond a trimming edge\n";
  EXPECT_EQ(outliers, 0);
  EXPECT_GT(trimmed, 1000);
  compareClosestPoints(patches, shape, 100);
}

#endif
