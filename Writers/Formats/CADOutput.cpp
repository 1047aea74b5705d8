// SPDX-License-Identifier: BSD-3-Clause
// The only file of the writers that includes OpenCASCADE.
#include "Formats/CADOutput.h"

#include "Base/UTF8.h"

#include <algorithm>

#ifndef BSPLINEVOLUME_WITH_OPENCASCADE

namespace bsv
{

std::string CADLibrary::close()
{
  throw Error(std::string(this->Format == CADFormat::STEP ? "STEP" : "IGES") +
    " files need OpenCASCADE, without which this program was built");
}

} // namespace bsv

#else

#include "Base/UnionFind.h"
#include "Execution/OpenCASCADESession.h"

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <IGESBasic_Name.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESData_IGESWriter.hxx>
#include <IGESData_Protocol.hxx>
#include <IGESSelect_WorkLibrary.hxx>
#include <IGESSolid_Face.hxx>
#include <Interface_HArray1OfHAsciiString.hxx>
#include <STEPConstruct.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <Standard_Version.hxx>
#include <StepBasic_Product.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array1OfPnt2d.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <TransferBRep.hxx>
#include <Transfer_FinderProcess.hxx>
#include <UnitsMethods.hxx>
#include <XSControl_TransferWriter.hxx>
#include <XSControl_WorkSession.hxx>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <sstream>

namespace bsv
{

namespace
{

/// Within it OpenCASCADE takes points for the same (Precision::Confusion).
constexpr double Confusion = 1e-7;
/// All digits of a double, with a point, in at most 23 characters: there is no more room in OpenCASCADE's writers.
constexpr const char* AllDigits = "%#.17G";
constexpr double Smallest = 1e-99;
constexpr double Largest = 1e99;

Handle(TCollection_HAsciiString) text(const std::string& value)
{
  return new TCollection_HAsciiString(value.c_str());
}

/// As OpenCASCADE calls a unit.
const char* unitName(double metres)
{
  static constexpr std::pair<const char*, double> units[] = { { "M", 1.0 }, { "CM", 1e-2 }, { "MM", 1e-3 },
    { "UM", 1e-6 }, { "KM", 1e3 }, { "INCH", 0.0254 }, { "FT", 0.3048 } };
  for (const auto& [name, size] : units)
  {
    if (std::abs(size - metres) <= 1e-9 * metres)
    {
      return name;
    }
  }
  throw Error("a unit of " + std::to_string(metres) + " metre is none that STEP and IGES files have");
}

/// The time that the file says, in UTC.
std::tm fileTime()
{
  const char* epoch = std::getenv("SOURCE_DATE_EPOCH");
  char* end = nullptr;
  const long long seconds = epoch ? std::strtoll(epoch, &end, 10) : 0;
  const std::time_t time = epoch && end != epoch && *end == 0 ? static_cast<std::time_t>(seconds) : 0;
  std::tm utc{};
  gmtime_r(&time, &utc);
  return utc;
}

std::string formatted(const std::tm& time, const char* format)
{
  char buffer[32];
  return std::string(buffer, std::strftime(buffer, sizeof(buffer), format, &time));
}

double writable(double value)
{
  if (!(std::abs(value) < Largest))
  {
    throw Error("has a number beyond 1e99");
  }
  return std::abs(value) < Smallest ? 0.0 : value;
}

gp_Pnt pointOf(const Vec3& x)
{
  return gp_Pnt(writable(x[0]), writable(x[1]), writable(x[2]));
}

/// Knots as OpenCASCADE has them, each once with its multiplicity.
struct KnotList
{
  explicit KnotList(const std::vector<double>& knots)
  {
    for (const double knot : knots)
    {
      if (this->Values.empty() || knot != this->Values.back())
      {
        this->Values.push_back(writable(knot));
        this->Counts.push_back(0);
      }
      ++this->Counts.back();
    }
  }
  TColStd_Array1OfReal values() const
  {
    return TColStd_Array1OfReal(this->Values[0], 1, static_cast<int>(this->Values.size()));
  }
  TColStd_Array1OfInteger counts() const
  {
    return TColStd_Array1OfInteger(this->Counts[0], 1, static_cast<int>(this->Counts.size()));
  }

private:
  std::vector<double> Values;
  std::vector<int> Counts;
};

Handle(Geom_BSplineSurface) toOpenCASCADE(const NURBSSurface& surface)
{
  const int nu = surface.count(0);
  const int nv = surface.count(1);
  TColgp_Array2OfPnt poles(1, nu, 1, nv);
  TColStd_Array2OfReal weights(1, nu, 1, nv);
  for (int j = 0; j < nv; ++j)
  {
    for (int i = 0; i < nu; ++i)
    {
      const Index place = i + Index(nu) * j;
      poles.SetValue(i + 1, j + 1, pointOf(surface.points[place]));
      weights.SetValue(i + 1, j + 1, surface.rational() ? writable(surface.weights[place]) : 1.0);
    }
  }
  const KnotList u(surface.knots[0]);
  const KnotList v(surface.knots[1]);
  Handle(Geom_BSplineSurface) result = surface.rational()
    ? new Geom_BSplineSurface(
        poles, weights, u.values(), v.values(), u.counts(), v.counts(), surface.degree[0], surface.degree[1])
    : new Geom_BSplineSurface(
        poles, u.values(), v.values(), u.counts(), v.counts(), surface.degree[0], surface.degree[1]);
  return result;
}

Handle(Geom_BSplineCurve) toOpenCASCADE(const SideCurve& side)
{
  const int n = static_cast<int>(side.points.size());
  TColgp_Array1OfPnt poles(1, n);
  TColStd_Array1OfReal weights(1, n);
  for (int i = 0; i < n; ++i)
  {
    poles.SetValue(i + 1, pointOf(side.points[i]));
    weights.SetValue(i + 1, side.weights.empty() ? 1.0 : writable(side.weights[i]));
  }
  const KnotList knots(side.knots);
  return side.weights.empty() ? new Geom_BSplineCurve(poles, knots.values(), knots.counts(), side.degree)
                              : new Geom_BSplineCurve(poles, weights, knots.values(), knots.counts(), side.degree);
}

/// A patch whose knots are clamped, so that its sides are rows of control points.
NURBSSurface clamped(const NURBSSurface& surface)
{
  const auto isClamped = [&](int d) {
    const std::vector<double>& knots = surface.knots[d];
    return knots.front() == surface.first(d) && knots.back() == surface.last(d);
  };
  if (isClamped(0) && isClamped(1))
  {
    return surface;
  }
  const Handle(Geom_BSplineSurface) whole = toOpenCASCADE(surface);
  whole->Segment(surface.first(0), surface.last(0), surface.first(1), surface.last(1));
  NURBSSurface result;
  result.degree = surface.degree;
  for (int d = 0; d < 2; ++d)
  {
    const TColStd_Array1OfReal& knots = d == 0 ? whole->UKnotSequence() : whole->VKnotSequence();
    result.knots[d].assign(knots.begin(), knots.end());
  }
  for (int j = 1; j <= whole->NbVPoles(); ++j)
  {
    for (int i = 1; i <= whole->NbUPoles(); ++i)
    {
      const gp_Pnt& p = whole->Pole(i, j);
      result.points.emplace_back(p.X(), p.Y(), p.Z());
      if (surface.rational())
      {
        result.weights.push_back(whole->Weight(i, j));
      }
    }
  }
  return result;
}

/// Corner at the start or end of a side; corner c = cu + 2 cv.
int sideCorner(int side, int end)
{
  return side < 2 ? side + 2 * end : end + 2 * (side - 2);
}

/// Builds the shells. A side is numbered 4 * patch + side.
class Sewing
{
public:
  explicit Sewing(const SurfacesToWrite& given)
    : Joins(given.joins)
    , Size(sizeOf(given.patches))
    , Corners(4 * static_cast<int>(given.patches.size()))
    , Shells(static_cast<int>(given.patches.size()))
  {
    for (const BodyPatch& patch : given.patches)
    {
      const std::string label = "patch " + std::to_string(this->Patches.size()) + " '" + patch.name + "' ";
      try
      {
        this->Patches.push_back(clamped(patch.surface));
        this->Surfaces.push_back(toOpenCASCADE(this->Patches.back()));
      }
      catch (const Error& error)
      {
        throw Error(label + error.what());
      }
      catch (const Standard_Failure& failure)
      {
        throw Error(label + "is refused by OpenCASCADE: " + failure.GetMessageString());
      }
    }
    this->classify();
    this->build();
  }

  /// One per patch, in their order.
  const std::vector<TopoDS_Face>& faces() const { return this->Faces; }
  /// All shells.
  const TopoDS_Shape& shape() const { return this->Shape; }

private:
  void classify()
  {
    this->Partner.assign(4 * this->Patches.size(), -1);
    this->Collapsed.assign(4 * this->Patches.size(), false);
    for (int side = 0; side < static_cast<int>(this->Partner.size()); ++side)
    {
      this->Sides.push_back(sideCurve(this->Patches[side / 4], side % 4));
      if (isCollapsed(this->Sides.back(), this->Size))
      {
        this->Collapsed[side] = true;
        this->Corners.unite(this->corner(side, 0), this->corner(side, 1));
      }
    }
    for (const PatchJoin& join : this->Joins)
    {
      const int a = 4 * join.patch[0] + join.side[0];
      const int b = 4 * join.patch[1] + join.side[1];
      for (int end = 0; end < 2; ++end)
      {
        this->Corners.unite(this->corner(a, end), this->corner(b, join.against ? 1 - end : end));
      }
      if (!this->Collapsed[a] && !this->Collapsed[b])
      {
        this->Shells.unite(join.patch[0], join.patch[1]);
        this->Partner[a] = b;
        this->Partner[b] = a;
        this->Against[{ std::min(a, b), std::max(a, b) }] = join.against;
      }
    }
  }

  int corner(int side, int end) const { return 4 * (side / 4) + sideCorner(side % 4, end); }

  Vec3 cornerPoint(int corner) const
  {
    const NURBSSurface& surface = this->Patches[corner / 4];
    const Index i = corner % 2 ? surface.count(0) - 1 : 0;
    const Index j = corner / 2 % 2 ? surface.count(1) - 1 : 0;
    return surface.points[i + surface.count(0) * j];
  }

  /// The side in the parameters of its patch, run through by `first`..`last`, or backwards.
  Handle(Geom2d_BSplineCurve) parameterLine(int side, double first, double last, bool backwards) const
  {
    const NURBSSurface& surface = this->Patches[side / 4];
    const int along = side % 4 < 2 ? 1 : 0;
    TColgp_Array1OfPnt2d poles(1, 2);
    for (int end = 0; end < 2; ++end)
    {
      double uv[2];
      uv[along] = end ? surface.last(along) : surface.first(along);
      uv[1 - along] = side % 2 ? surface.last(1 - along) : surface.first(1 - along);
      poles.SetValue((end != 0) != backwards ? 2 : 1, gp_Pnt2d(uv[0], uv[1]));
    }
    const double ends[] = { first, last };
    const int counts[] = { 2, 2 };
    return new Geom2d_BSplineCurve(
      poles, TColStd_Array1OfReal(ends[0], 1, 2), TColStd_Array1OfInteger(counts[0], 1, 2), 1);
  }

  /// Largest distance between control points of a side and the one it is sewn to.
  double gap(int a, int b, bool against) const
  {
    const std::vector<Vec3>& p = this->Sides[a].points;
    const std::vector<Vec3>& q = this->Sides[b].points;
    double largest = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
      largest = std::max(largest, (p[i] - q[against ? q.size() - 1 - i : i]).norm());
    }
    return largest;
  }

  void build()
  {
    std::vector<TopoDS_Vertex> vertices(4 * this->Patches.size());
    std::vector<double> reach(vertices.size(), Confusion);
    for (int c = 0; c < static_cast<int>(vertices.size()); ++c)
    {
      const Index root = this->Corners.find(c);
      reach[root] =
        std::max(reach[root], Confusion + (this->cornerPoint(c) - this->cornerPoint(static_cast<int>(root))).norm());
    }
    for (int c = 0; c < static_cast<int>(vertices.size()); ++c)
    {
      if (this->Corners.find(c) == c)
      {
        this->Builder.MakeVertex(vertices[c], pointOf(this->cornerPoint(c)), reach[c]);
      }
    }
    for (std::size_t p = 0; p < this->Patches.size(); ++p)
    {
      this->Faces.emplace_back();
      this->Builder.MakeFace(this->Faces.back(), this->Surfaces[p], Confusion);
    }

    // Edges with their curves in both faces; the side with the lower number gives the curve in space.
    std::vector<TopoDS_Edge> edges(4 * this->Patches.size());
    for (int a = 0; a < static_cast<int>(edges.size()); ++a)
    {
      const int b = this->Partner[a];
      if (b >= 0 && b < a)
      {
        edges[a] = edges[b];
        continue;
      }
      TopoDS_Edge& edge = edges[a];
      const SideCurve& side = this->Sides[a];
      const double first = side.knots.front();
      const double last = side.knots.back();
      const TopoDS_Face& face = this->Faces[a / 4];
      const bool against = b >= 0 && this->Against.at({ a, b });
      const double tolerance = Confusion + (b >= 0 ? this->gap(a, b, against) : 0.0);
      if (this->Collapsed[a])
      {
        this->Builder.MakeEdge(edge);
        this->Builder.Degenerated(edge, Standard_True);
      }
      else
      {
        this->Builder.MakeEdge(edge, toOpenCASCADE(side), tolerance);
      }
      const Handle(Geom2d_BSplineCurve) own = this->parameterLine(a, first, last, false);
      if (b < 0)
      {
        this->Builder.UpdateEdge(edge, own, face, tolerance);
      }
      else
      {
        const Handle(Geom2d_BSplineCurve) other = this->parameterLine(b, first, last, against);
        if (a / 4 == b / 4)
        {
          // A closed patch: the first curve belongs to the edge as it runs, the second to the reversed one.
          const bool forward = this->runsForward(a, false);
          this->Builder.UpdateEdge(edge, forward ? own : other, forward ? other : own, face, tolerance);
        }
        else
        {
          this->Builder.UpdateEdge(edge, own, face, tolerance);
          this->Builder.UpdateEdge(edge, other, this->Faces[b / 4], tolerance);
        }
      }
      this->Builder.Range(edge, first, last);
      for (int end = 0; end < 2; ++end)
      {
        const TopoDS_Vertex& vertex = vertices[this->Corners.find(this->corner(a, end))];
        this->Builder.Add(edge, vertex.Oriented(end ? TopAbs_REVERSED : TopAbs_FORWARD));
      }
    }

    std::map<Index, TopoDS_Shell> shells;
    for (int p = 0; p < static_cast<int>(this->Patches.size()); ++p)
    {
      TopoDS_Wire wire;
      this->Builder.MakeWire(wire);
      for (const int s : { 2, 1, 3, 0 })
      {
        const int side = 4 * p + s;
        const int partner = this->Partner[side];
        const bool backwards = partner >= 0 && partner < side && this->Against.at({ partner, side });
        this->Builder.Add(
          wire, edges[side].Oriented(this->runsForward(side, backwards) ? TopAbs_FORWARD : TopAbs_REVERSED));
      }
      wire.Closed(Standard_True);
      this->Builder.Add(this->Faces[p], wire);
      TopoDS_Shell& shell = shells[this->Shells.find(p)];
      if (shell.IsNull())
      {
        this->Builder.MakeShell(shell);
      }
      this->Builder.Add(shell, this->Faces[p]);
    }
    TopoDS_Compound all;
    this->Builder.MakeCompound(all);
    for (auto& [root, shell] : shells)
    {
      shell.Closed(BRep_Tool::IsClosed(shell));
      this->Builder.Add(all, shell);
      this->Shape = shell;
    }
    if (shells.size() > 1)
    {
      this->Shape = all;
    }
  }

  /// Whether the boundary of the patch, counter-clockwise around its normal, runs along an edge.
  /// @param backwards whether the edge runs against the parameter of the side
  static bool runsForward(int side, bool backwards)
  {
    const bool along = side % 4 == 1 || side % 4 == 2;
    return along != backwards;
  }

  const std::vector<PatchJoin>& Joins;
  double Size;
  UnionFind Corners;
  UnionFind Shells;
  std::vector<NURBSSurface> Patches;
  std::vector<Handle(Geom_BSplineSurface)> Surfaces;
  std::vector<SideCurve> Sides;
  std::vector<bool> Collapsed;
  /// The side that each is sewn to, or -1.
  std::vector<int> Partner;
  std::map<std::array<int, 2>, bool> Against;
  BRep_Builder Builder;
  std::vector<TopoDS_Face> Faces;
  TopoDS_Shape Shape;
};

/// A text as it stands between the quotes of a STEP file (ISO 10303-21).
std::string stepText(const std::string& utf8)
{
  std::string result;
  for (std::size_t i = 0; i < utf8.size();)
  {
    const unsigned char first = static_cast<unsigned char>(utf8[i]);
    const int length = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    unsigned code = length == 1 ? first : first & (0xff >> (length + 1));
    for (int k = 1; k < length; ++k)
    {
      code = code << 6 | (static_cast<unsigned char>(utf8[i + k]) & 0x3f);
    }
    i += length;
    char buffer[24];
    if (code >= ' ' && code < 0x7f)
    {
      result += static_cast<char>(code);
      if (code == '\'' || code == '\\')
      {
        result += static_cast<char>(code);
      }
      continue;
    }
    std::snprintf(buffer, sizeof(buffer), code < 0x10000 ? "\\X2\\%04X\\X0\\" : "\\X4\\%08X\\X0\\", code);
    result += buffer;
  }
  return result;
}

/// Names of a STEP file: OpenCASCADE's writer breaks long ones into lines and doubles the signs of the encoding, so it
/// gets short tokens that are replaced behind it.
class StepNames
{
public:
  Handle(TCollection_HAsciiString) token(const std::string& name)
  {
    this->Names.push_back(stepText(name));
    return text("@@" + std::to_string(this->Names.size() - 1) + "@@");
  }
  std::string in(const std::string& content) const
  {
    std::string result;
    std::size_t done = 0;
    for (std::size_t at = content.find("'@@"); at != std::string::npos; at = content.find("'@@", done))
    {
      const std::size_t end = content.find("@@'", at + 3);
      result.append(content, done, at + 1 - done);
      result += this->Names[std::strtoul(content.c_str() + at + 3, nullptr, 10)];
      done = end + 2;
    }
    return result.append(content, done);
  }

private:
  std::vector<std::string> Names;
};

void checkWritten(bool good, const char* format)
{
  if (!good)
  {
    throw Error(std::string("OpenCASCADE could not write the patches as ") + format);
  }
}

std::string writeSTEP(const Sewing& sewing, const std::vector<std::string>& names, const char* unit, double metres,
  const std::string& name, OpenCASCADESession& session)
{
  STEPControl_Controller::Init();
  session.set("write.step.unit", unit);
  session.set("xstep.cascade.unit", unit);
  session.set("write.step.assembly", 0);
  session.set("write.step.schema", "AP214IS");
  session.set("write.surfacecurve.mode", 1);
  STEPControl_Writer writer;
#if OCC_VERSION_HEX >= 0x070700
  // The model keeps its units itself, in millimetres.
  writer.Model()->SetLocalLengthUnit(1000.0 * metres);
  writer.Model()->SetWriteLengthUnit(1000.0 * metres);
#else
  (void)metres;
#endif
  checkWritten(writer.Transfer(sewing.shape(), STEPControl_ShellBasedSurfaceModel) == IFSelect_RetDone, "STEP");

  StepNames tokens;
  const Handle(Transfer_FinderProcess) process = writer.WS()->TransferWriter()->FinderProcess();
  for (std::size_t f = 0; f < names.size(); ++f)
  {
    const Handle(StepRepr_RepresentationItem) item = STEPConstruct::FindEntity(process, sewing.faces()[f]);
    checkWritten(!item.IsNull(), "STEP");
    item->SetName(tokens.token(names[f]));
  }
  const Handle(StepData_StepModel) model = writer.Model();
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    const Handle(StepBasic_Product) product = Handle(StepBasic_Product)::DownCast(model->Value(i));
    if (!product.IsNull())
    {
      product->SetId(tokens.token(name));
      product->SetName(tokens.token(name));
    }
  }
  APIHeaderSection_MakeHeader header(model);
  header.SetName(tokens.token(name));
  header.SetTimeStamp(text(formatted(fileTime(), "%Y-%m-%dT%H:%M:%S")));
  header.SetAuthorValue(1, text(""));
  header.SetOrganizationValue(1, text(""));
  header.SetPreprocessorVersion(text("Open CASCADE Technology"));
  header.SetOriginatingSystem(text("BSplineVolume"));
  header.SetAuthorisation(text(""));
  header.Apply(model);

  StepData_StepWriter output(model);
  output.FloatWriter().SetFormat(AllDigits);
  output.SendModel(Handle(StepData_Protocol)::DownCast(model->Protocol()));
  std::ostringstream content;
  checkWritten(output.Print(content), "STEP");
  return tokens.in(content.str());
}

std::string writeIGES(const Sewing& sewing, const std::vector<std::string>& names, const char* unit, double metres,
  const std::string& name, OpenCASCADESession& session)
{
  IGESControl_Controller::Init();
  session.set("xstep.cascade.unit", unit);
  session.set("write.iges.plane.mode", 0);
  IGESControl_Writer writer(unit, 1);
  const Handle(IGESData_IGESModel) model = writer.Model();
  model->ChangeGlobalSection().SetCascadeUnit(1000.0 * metres); // in millimetres
  checkWritten(writer.AddShape(sewing.shape()), "IGES");

  std::vector<Handle(IGESSolid_Face)> faces;
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    const Handle(IGESSolid_Face) face = Handle(IGESSolid_Face)::DownCast(model->Value(i));
    if (!face.IsNull())
    {
      faces.push_back(face);
    }
  }
  checkWritten(faces.size() == names.size(), "IGES");
  for (std::size_t f = 0; f < names.size(); ++f)
  {
    const Handle(IGESSolid_Face) face =
      Handle(IGESSolid_Face)::DownCast(TransferBRep::TransientFromShape(writer.TransferProcess(), sewing.faces()[f]));
    checkWritten(!face.IsNull(), "IGES");
    std::string label;
    std::copy_if(names[f].begin(), names[f].end(), std::back_inserter(label),
      [](char letter) { return letter >= ' ' && letter <= '~'; });
    if (!label.empty())
    {
      face->SetLabel(text(label.substr(0, 8)));
    }
    const Handle(IGESBasic_Name) property = new IGESBasic_Name;
    property->Init(1, text(names[f]));
    face->AddProperty(property);
    writer.AddEntity(property);
  }
  IGESData_GlobalSection global = model->GlobalSection();
  const std::string date = formatted(fileTime(), "%Y%m%d.%H%M%S");
  global.SetSendName(text(name));
  global.SetFileName(text(name + ".igs"));
  global.SetSystemId(text("BSplineVolume"));
  global.SetInterfaceVersion(text("Open CASCADE Technology"));
  global.SetReceiveName(text(name));
  global.SetAuthorName(text(""));
  global.SetCompanyName(text(""));
  global.SetDate(text(date));
  global.SetLastChangeDate(text(date));
  model->SetGlobalSection(global);
  writer.ComputeModel();

  IGESData_IGESWriter output(model);
  output.FloatWriter().SetFormat(AllDigits);
  output.SendModel(IGESSelect_WorkLibrary::DefineProtocol());
  std::ostringstream content;
  checkWritten(output.Print(content), "IGES");
  return content.str();
}

} // namespace

std::string CADLibrary::close()
{
  const char* unit = unitName(this->Metres);
  std::vector<std::string> names;
  for (const BodyPatch& patch : this->Surfaces.patches)
  {
    names.push_back(patch.name);
  }
  OpenCASCADESession session;
  const double before = UnitsMethods::GetCasCadeLengthUnit();
  session.finally([=] { UnitsMethods::SetCasCadeLengthUnit(before); });
  try
  {
    const Sewing sewing(this->Surfaces);
    return this->Format == CADFormat::STEP ? writeSTEP(sewing, names, unit, this->Metres, this->Part, session)
                                           : writeIGES(sewing, names, unit, this->Metres, this->Part, session);
  }
  catch (const Standard_Failure& failure)
  {
    throw Error(std::string("OpenCASCADE could not write the patches: ") + failure.GetMessageString());
  }
}

} // namespace bsv

#endif

namespace bsv
{

void CADLibrary::patch(const std::string& name, const std::array<int, 2>& degree, const std::vector<double>& knotsU,
  const std::vector<double>& knotsV, const std::vector<Vec3>& points, const std::vector<double>& weights)
{
  BodyPatch patch;
  patch.name = name;
  patch.surface.degree = degree;
  patch.surface.knots = { knotsU, knotsV };
  patch.surface.points = points;
  patch.surface.weights = weights;
  this->Surfaces.patches.push_back(std::move(patch));
}

void CADLibrary::joins(const std::vector<PatchJoin>& joins)
{
  this->Surfaces.joins = joins;
}

void CADLibrary::kind(CADFormat format, double metres, const std::string& name)
{
  this->Format = format;
  this->Metres = metres;
  this->Part = name;
}

void writeCAD(const SurfacesToWrite& surfaces, CADFormat format, double metres, const std::string& name,
  AtomicFile& file, const Execution& run, std::vector<std::string>& notes)
{
  double points = 0.0;
  for (const BodyPatch& patch : surfaces.patches)
  {
    points += static_cast<double>(patch.surface.points.size());
  }
  // OpenCASCADE writes more than 10,000 control points a second.
  LibraryFile<CADLibrary> library(file, 60.0 + points / 1e3, run, notes);
  library.call<&CADLibrary::kind>(format, metres, validUTF8(name));
  library.call<&CADLibrary::joins>(surfaces.joins);
  int changed = 0;
  for (const BodyPatch& patch : surfaces.patches)
  {
    std::string legal = validUTF8(patch.name);
    std::replace_if(
      legal.begin(), legal.end(), [](char letter) { return letter == '\n' || letter == '\t'; }, ' ');
    changed += legal != patch.name;
    const NURBSSurface& surface = patch.surface;
    library.call<&CADLibrary::patch>(
      legal, surface.degree, surface.knots[0], surface.knots[1], surface.points, surface.weights);
  }
  if (changed > 0)
  {
    notes.push_back(
      "the names of " + std::to_string(changed) + " patches hold characters that no text has; they were replaced");
  }
  file.write(library.close());
}

} // namespace bsv
