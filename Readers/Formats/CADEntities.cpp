// SPDX-License-Identifier: BSD-3-Clause
// Entities of IGES and STEP files: which of them matter, their units, names and layers, and the shapes they become.
#include "Formats/CADShape.h"

#include <BRep_Builder.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGeom_BSplineSurface.hxx>
#include <Interface_Check.hxx>
#include <Interface_EntityIterator.hxx>
#include <Interface_Graph.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Interface_ReportEntity.hxx>
#include <STEPControl_Reader.hxx>
#include <StepBasic_ProductDefinitionRelationship.hxx>
#include <StepGeom_Surface.hxx>
#include <StepRepr_NextAssemblyUsageOccurrence.hxx>
#include <StepRepr_PropertyDefinition.hxx>
#include <StepRepr_Representation.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <StepRepr_SpecifiedHigherUsageOccurrence.hxx>
#include <StepShape_Face.hxx>
#include <StepShape_GeometricSet.hxx>
#include <StepShape_ShapeDefinitionRepresentation.hxx>
#include <StepVisual_Invisibility.hxx>
#include <StepVisual_InvisibleItem.hxx>
#include <StepVisual_OverRidingStyledItem.hxx>
#include <StepVisual_PresentationLayerAssignment.hxx>
#include <StepVisual_PresentationStyleByContext.hxx>
#include <StepVisual_StyleContextSelect.hxx>
#include <StepVisual_StyledItem.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColStd_HArray2OfReal.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TColgp_HArray2OfXYZ.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Datum3D.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS_Compound.hxx>
#include <TransferBRep.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <memory>
#include <unordered_set>
#include <vector>

namespace bsv::cad
{

namespace
{

/// Mode in which OpenCASCADE looks for the entity of a shape: whichever way it came from it.
constexpr int AnyResult = -1;

/// Metres per unit of a name that OpenCASCADE or the STEP file gives; 0 if unknown.
double metres(std::string name)
{
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  static const std::map<std::string, double> units = { { "metre", 1.0 }, { "meter", 1.0 }, { "m", 1.0 },
    { "millimetre", 1e-3 }, { "millimeter", 1e-3 }, { "mm", 1e-3 }, { "centimetre", 1e-2 }, { "centimeter", 1e-2 },
    { "cm", 1e-2 }, { "kilometre", 1e3 }, { "kilometer", 1e3 }, { "km", 1e3 }, { "micrometre", 1e-6 },
    { "micrometer", 1e-6 }, { "micron", 1e-6 }, { "um", 1e-6 }, { "inch", 0.0254 }, { "in", 0.0254 },
    { "foot", 0.3048 }, { "feet", 0.3048 }, { "ft", 0.3048 }, { "mile", 1609.344 }, { "mi", 1609.344 },
    { "mil", 2.54e-5 }, { "microinch", 2.54e-8 }, { "uin", 2.54e-8 } };
  const auto found = units.find(name);
  return found == units.end() ? 0.0 : found->second;
}

/// Metres per unit of an IGES file; 0 if it names none that is known.
double igesUnit(const IGESData_GlobalSection& global)
{
  static const double byFlag[] = { 0.0, 0.0254, 1e-3, 0.0, 0.3048, 1609.344, 1.0, 1e3, 2.54e-5, 1e-6, 1e-2, 2.54e-8 };
  const int flag = global.UnitFlag();
  if (flag >= 1 && flag <= 11 && byFlag[flag] > 0.0)
  {
    return byFlag[flag];
  }
  return global.UnitName().IsNull() ? 0.0 : metres(global.UnitName()->ToCString());
}

std::string textOf(const Handle(TCollection_HAsciiString) & text)
{
  if (text.IsNull())
  {
    return {};
  }
  std::string result = text->ToCString();
  while (!result.empty() && result.back() == ' ')
  {
    result.pop_back();
  }
  return result.substr(std::min(result.find_first_not_of(' '), result.size()));
}

/// The text of a message, whose placeholders OpenCASCADE may have left empty.
std::string cleaned(std::string text)
{
  for (const char* placeholder : { "%d", "%s", "%f" })
  {
    for (std::size_t at = text.find(placeholder); at != std::string::npos; at = text.find(placeholder))
    {
      text.erase(at, text[at + 2] == ' ' ? 3 : 2);
    }
  }
  return text;
}

std::string labelOf(const Handle(Interface_InterfaceModel) & model, int number)
{
  const Handle(TCollection_HAsciiString) label = model->StringLabel(model->Value(number));
  return label.IsNull() ? std::to_string(number) : textOf(label);
}

/// "type 128 (IGESGeom_BSplineSurface)", "CURVE_STYLE".
std::string typeOf(const Handle(Interface_InterfaceModel) & model, int number)
{
  const Handle(Standard_Transient) entity = model->Value(number);
  const Handle(IGESData_IGESEntity) iges = Handle(IGESData_IGESEntity)::DownCast(entity);
  return iges.IsNull() ? entity->DynamicType()->Name()
                       : "type " + std::to_string(iges->TypeNumber()) + " (" + iges->DynamicType()->Name() + ")";
}

/// Types of IGES that a face can depend on: curves, surfaces, solids and their places, not notes, views and colours.
bool isIGESShape(int type)
{
  return (type >= 100 && type <= 199) || type == 430 || (type >= 500 && type <= 599);
}

/// Those that become faces, and those that hold others.
bool isIGESSurface(int type)
{
  return type == 114 || type == 118 || type == 120 || type == 122 || type == 128 || (type >= 140 && type <= 144) ||
    (type >= 184 && type <= 198) || type == 308 || type == 402 || type == 408 || type == 430 ||
    (type >= 502 && type <= 514);
}

/// Numbers of the entities that the shape and place of faces depend on.
std::unordered_set<int> neededEntities(const Handle(IGESData_IGESModel) & model)
{
  std::unordered_set<int> needed;
  const Interface_Graph graph(model, Standard_False);
  std::vector<int> open;
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    const Handle(IGESData_IGESEntity) entity = Handle(IGESData_IGESEntity)::DownCast(model->Value(i));
    if (!entity.IsNull() && isIGESSurface(entity->TypeNumber()) && needed.insert(i).second)
    {
      open.push_back(i);
    }
  }
  while (!open.empty())
  {
    const Handle(Standard_Transient) entity = model->Value(open.back());
    open.pop_back();
    const int type = Handle(IGESData_IGESEntity)::DownCast(entity)->TypeNumber();
    if (type == 308 || type == 402 || type == 408)
    {
      continue; // the items of a list count for themselves
    }
    for (Interface_EntityIterator shared = graph.Shareds(entity); shared.More(); shared.Next())
    {
      const Handle(IGESData_IGESEntity) used = Handle(IGESData_IGESEntity)::DownCast(shared.Value());
      const int number = used.IsNull() ? 0 : model->Number(used);
      if (number > 0 && isIGESShape(used->TypeNumber()) && needed.insert(number).second)
      {
        open.push_back(number);
      }
    }
  }
  return needed;
}

/// A B-spline surface without its four last numbers, the ends of its domain: the knots say the same.
bool completeDomain(const Handle(IGESGeom_BSplineSurface) & surface)
{
  if (surface.IsNull() || surface->NbPolesU() < 2 || surface->NbPolesV() < 2)
  {
    return false;
  }
  const int upper[2] = { surface->UpperIndexU(), surface->UpperIndexV() };
  const int degree[2] = { surface->DegreeU(), surface->DegreeV() };
  std::array<Handle(TColStd_HArray1OfReal), 2> knots;
  for (int d = 0; d < 2; ++d)
  {
    const int last = upper[d] + 1;
    if ((d == 0 ? surface->NbKnotsU() : surface->NbKnotsV()) != last + degree[d] + 1)
    {
      return false;
    }
    knots[d] = new TColStd_HArray1OfReal(-degree[d], last);
    for (int k = -degree[d]; k <= last; ++k)
    {
      knots[d]->SetValue(k, d == 0 ? surface->KnotU(k) : surface->KnotV(k));
    }
  }
  const Handle(TColStd_HArray2OfReal) weights = new TColStd_HArray2OfReal(0, upper[0], 0, upper[1]);
  const Handle(TColgp_HArray2OfXYZ) poles = new TColgp_HArray2OfXYZ(0, upper[0], 0, upper[1]);
  for (int j = 0; j <= upper[1]; ++j)
  {
    for (int i = 0; i <= upper[0]; ++i)
    {
      weights->SetValue(i, j, surface->Weight(i, j));
      poles->SetValue(i, j, surface->Pole(i, j).XYZ());
    }
  }
  surface->Init(upper[0], upper[1], degree[0], degree[1], surface->IsClosedU(), surface->IsClosedV(),
    surface->IsPolynomial(), surface->IsPeriodicU(), surface->IsPeriodicV(), knots[0], knots[1], weights, poles,
    knots[0]->Value(0), knots[0]->Value(upper[0] + 1 - degree[0]), knots[1]->Value(0),
    knots[1]->Value(upper[1] + 1 - degree[1]));
  return true;
}

/// @throws Error naming the surface whose knots decrease: OpenCASCADE leaves it out without a word.
void checkKnots(const Handle(IGESData_IGESModel) & model, const std::string& fileName)
{
  for (int e = 1; e <= model->NbEntities(); ++e)
  {
    const Handle(IGESGeom_BSplineSurface) surface = Handle(IGESGeom_BSplineSurface)::DownCast(model->Value(e));
    for (int d = 0; d < 2 && !surface.IsNull(); ++d)
    {
      const int first = -(d == 0 ? surface->DegreeU() : surface->DegreeV());
      const int count = d == 0 ? surface->NbKnotsU() : surface->NbKnotsV();
      const auto knot = [&](int k) { return d == 0 ? surface->KnotU(first + k) : surface->KnotV(first + k); };
      for (int k = 1; k < count; ++k)
      {
        if (!(knot(k) >= knot(k - 1)))
        {
          throw Error(fileName + ": surface " + labelOf(model, e) + ": the knots of " + "uv"[d] + " decrease from " +
            std::to_string(knot(k - 1)) + " to " + std::to_string(knot(k)) + " (knot " + std::to_string(k + 1) + ")");
        }
      }
    }
  }
}

/// Refuses files of which an entity could not be read as what it claims to be, if faces depend on it: what refers to it
/// would meet nothing, at which OpenCASCADE does not look. Other entities are counted.
/// @param needed(number, label) whether faces depend on an entity
template <typename Needed>
void checkEntities(const Handle(Interface_InterfaceModel) & model, const std::string& fileName, const Needed& needed,
  std::map<std::string, int>& broken)
{
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    if (!model->IsReportEntity(i))
    {
      continue;
    }
    const Handle(Interface_Check) check = model->ReportEntity(i)->Check();
    if (check.IsNull() || !check->HasFailed())
    {
      continue;
    }
    const std::string label = labelOf(model, i);
    if (!needed(i, label))
    {
      ++broken[typeOf(model, i) + " that could not be read"];
      continue;
    }
    bool onlyDomain = true;
    for (int f = 1; f <= check->NbFails(); ++f)
    {
      const std::string text = check->CFail(f);
      onlyDomain = onlyDomain &&
        (text.find("Starting Value") != std::string::npos || text.find("Ending Value") != std::string::npos);
    }
    if (onlyDomain && completeDomain(Handle(IGESGeom_BSplineSurface)::DownCast(model->Value(i))))
    {
      model->ClearReportEntity(i);
      continue;
    }
    throw Error(fileName + ": entity " + label + " (" + typeOf(model, i) + "): " + cleaned(check->CFail(1)));
  }
}

int faceCount(const TopoDS_Shape& shape)
{
  TopTools_IndexedMapOfShape faces;
  if (!shape.IsNull())
  {
    TopExp::MapShapes(shape, TopAbs_FACE, faces);
  }
  return faces.Extent();
}

/// The shape that came of an entity, which need not be a root.
TopoDS_Shape shapeOf(XSControl_Reader& reader, const Handle(Standard_Transient) & entity)
{
  return entity.IsNull() ? TopoDS_Shape()
                         : TransferBRep::ShapeResult(reader.WS()->TransferReader()->TransientProcess(), entity);
}

/// Adds the faces of a shape, wherever they are placed.
void addFaces(const TopoDS_Shape& shape, std::unordered_set<const TopoDS_TShape*>& faces)
{
  for (TopExp_Explorer at(shape, TopAbs_FACE); !shape.IsNull() && at.More(); at.Next())
  {
    faces.insert(at.Current().TShape().get());
  }
}

/// Whether a location is `place` in an assembly that may be anywhere. Locations begin with what is done first.
bool isIn(TopLoc_Location location, TopLoc_Location place)
{
  if (place.IsIdentity())
  {
    return location.IsIdentity();
  }
  while (!place.IsIdentity() && !location.IsIdentity() && place.FirstDatum() == location.FirstDatum() &&
    place.FirstPower() == location.FirstPower())
  {
    place = place.NextLocation();
    location = location.NextLocation();
  }
  return place.IsIdentity();
}

/// Faces that a STEP file hides.
class HiddenFaces
{
public:
  explicit HiddenFaces(STEPControl_Reader& reader)
    : Reader(reader)
    , Graph(reader.WS()->Model(), Standard_False)
  {
  }

  void add(const StepVisual_InvisibleItem& item)
  {
    const Handle(StepVisual_StyledItem) styled = item.StyledItem();
    if (!styled.IsNull())
    {
      this->add(styled->Item(), this->placeOf(styled));
    }
    const Handle(StepVisual_PresentationLayerAssignment) layer = item.PresentationLayerAssignment();
    for (int k = 1; !layer.IsNull() && k <= layer->NbAssignedItems(); ++k)
    {
      this->add(layer->AssignedItemsValue(k).Value(), {});
    }
  }

  bool has(const TopoDS_Face& face) const
  {
    if (this->Everywhere.count(face.TShape().get()) > 0)
    {
      return true;
    }
    const auto found = this->Places.find(face.TShape().get());
    return found != this->Places.end() &&
      std::any_of(found->second.begin(), found->second.end(),
        [&](const TopLoc_Location& place) { return isIn(face.Location(), place); });
  }

private:
  /// Where a component of an assembly is: nothing for what is no component.
  struct Place
  {
    TopoDS_Shape component;
    TopLoc_Location assembly;
  };

  Place placeOf(const Handle(StepBasic_ProductDefinitionRelationship) & usage) const
  {
    const auto higher = Handle(StepRepr_SpecifiedHigherUsageOccurrence)::DownCast(usage);
    if (higher.IsNull())
    {
      return { shapeOf(this->Reader, usage), {} };
    }
    const Place upper = this->placeOf(higher->UpperUsage());
    Place place = this->placeOf(higher->NextUsage());
    place.assembly = upper.assembly * upper.component.Location();
    return place;
  }

  /// The component that alone a style means: the context of its style is the placement of one.
  Place placeOf(const Handle(StepVisual_StyledItem) & styled) const
  {
    const bool overrides = styled->IsKind(STANDARD_TYPE(StepVisual_OverRidingStyledItem));
    for (int n = 1; overrides && n <= styled->NbStyles(); ++n)
    {
      const auto style = Handle(StepVisual_PresentationStyleByContext)::DownCast(styled->StylesValue(n));
      const Handle(StepRepr_Representation) context =
        style.IsNull() ? Handle(StepRepr_Representation)() : style->StyleContext().Representation();
      if (context.IsNull())
      {
        continue;
      }
      for (Interface_EntityIterator user = this->Graph.Sharings(context); user.More(); user.Next())
      {
        const auto definition = Handle(StepShape_ShapeDefinitionRepresentation)::DownCast(user.Value());
        const Handle(StepRepr_PropertyDefinition) property =
          definition.IsNull() ? Handle(StepRepr_PropertyDefinition)() : definition->Definition().PropertyDefinition();
        const Handle(StepBasic_ProductDefinitionRelationship) usage = property.IsNull()
          ? Handle(StepBasic_ProductDefinitionRelationship)()
          : property->Definition().ProductDefinitionRelationship();
        if (!usage.IsNull())
        {
          return this->placeOf(usage);
        }
      }
    }
    return {};
  }

  void add(const Handle(Standard_Transient) & entity, const Place& place)
  {
    std::unordered_set<const TopoDS_TShape*> faces;
    addFaces(shapeOf(this->Reader, entity), faces);
    if (place.component.IsNull())
    {
      this->Everywhere.insert(faces.begin(), faces.end());
      return;
    }
    for (TopExp_Explorer at(place.component, TopAbs_FACE); at.More(); at.Next())
    {
      const TopoDS_TShape* face = at.Current().TShape().get();
      if (faces.count(face) > 0)
      {
        this->Places[face].push_back(place.assembly * at.Current().Location());
      }
    }
  }

  STEPControl_Reader& Reader;
  const Interface_Graph Graph;
  std::unordered_set<const TopoDS_TShape*> Everywhere;
  /// The locations with which those of hidden faces begin.
  std::map<const TopoDS_TShape*, std::vector<TopLoc_Location>> Places;
};

/// Entities that an IGES file hides (blanks), by themselves or with all that they are part of.
class BlankedEntities
{
public:
  explicit BlankedEntities(const Handle(IGESData_IGESModel) & model)
    : Graph(model, Standard_False)
  {
  }

  bool has(const Handle(IGESData_IGESEntity) & entity)
  {
    const auto [known, isNew] = this->Known.try_emplace(entity.get(), false);
    if (!isNew)
    {
      return known->second;
    }
    bool blanked = this->isBlanked(*entity);
    if (!blanked)
    {
      int wholes = 0;
      int blankedWholes = 0;
      for (Interface_EntityIterator user = this->Graph.Sharings(entity); user.More(); user.Next())
      {
        const Handle(IGESData_IGESEntity) whole = Handle(IGESData_IGESEntity)::DownCast(user.Value());
        if (!whole.IsNull() && isWhole(*whole))
        {
          ++wholes;
          blankedWholes += this->has(whole);
        }
      }
      blanked = wholes > 0 && blankedWholes == wholes;
    }
    this->Known[entity.get()] = blanked;
    return blanked;
  }

private:
  /// Faces, shells, solids, assemblies and groups.
  static bool isWhole(const IGESData_IGESEntity& entity)
  {
    const int type = entity.TypeNumber();
    const int form = entity.FormNumber();
    const bool group = type == 402 && (form == 1 || form == 7 || form == 14 || form == 15);
    return group || type == 184 || type == 186 || type == 308 || type == 408 || type == 430 || type == 510 ||
      type == 514;
  }

  /// The untrimmed surface of a trimmed one is often hidden: the trimmed one counts.
  static bool isBlanked(const IGESData_IGESEntity& entity)
  {
    const int status = entity.SubordinateStatus();
    return entity.BlankStatus() == 1 && (status == 0 || status == 2 || isWhole(entity));
  }

  const Interface_Graph Graph;
  std::map<const Standard_Transient*, bool> Known;
};

/// Shapes of all roots but the hidden ones, and the roots of which nothing came.
/// @param dropped counts of what is left out
TopoDS_Shape transfer(XSControl_Reader& reader, std::map<std::string, int>& dropped)
{
  BRep_Builder builder;
  TopoDS_Compound all;
  builder.MakeCompound(all);
  const int roots = reader.NbRootsForTransfer();
  for (int i = 1; i <= roots; ++i)
  {
    const int before = reader.NbShapes();
    reader.TransferOneRoot(i);
    const Handle(Standard_Transient) root = reader.RootForTransfer(i);
    const Handle(IGESData_IGESEntity) iges = Handle(IGESData_IGESEntity)::DownCast(root);
    const bool hidden = !iges.IsNull() && iges->BlankStatus() == 1;
    for (int n = before + 1; n <= reader.NbShapes(); ++n)
    {
      if (!hidden && !reader.Shape(n).IsNull())
      {
        builder.Add(all, reader.Shape(n));
      }
      const int faces = hidden ? faceCount(reader.Shape(n)) : 0;
      if (faces > 0)
      {
        dropped[HiddenSurface] += faces;
      }
    }
    if (reader.NbShapes() == before && !hidden)
    {
      ++dropped[iges.IsNull()
          ? std::string("STEP entity ") + root->DynamicType()->Name()
          : "IGES entity of type " + std::to_string(iges->TypeNumber()) + " (" + root->DynamicType()->Name() + ")"];
    }
  }
  return all;
}

/// Faces that came of an entity.
int faceCount(XSControl_Reader& reader, const Handle(Standard_Transient) & entity)
{
  return faceCount(shapeOf(reader, entity));
}

/// @throws Error naming a surface of which no face came, and that is no part of another one: OpenCASCADE leaves it out
/// without a word.
void checkFaces(IGESControl_Reader& reader, const std::string& fileName)
{
  const Handle(IGESData_IGESModel) model = reader.IGESModel();
  const auto entity = [&](int number) { return Handle(IGESData_IGESEntity)::DownCast(model->Value(number)); };
  constexpr int Subfigure = 308;
  // It is part of a face, and no face itself.
  constexpr int UnboundedPlane = 190;
  const Interface_Graph graph(model, Standard_False);
  std::unordered_set<Standard_Transient*> parts;
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    const int type = entity(i).IsNull() ? 0 : entity(i)->TypeNumber();
    for (Interface_EntityIterator used = graph.Shareds(model->Value(i));
         (isIGESShape(type) || type == Subfigure) && used.More(); used.Next())
    {
      parts.insert(used.Value().get());
    }
  }
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    const Handle(IGESData_IGESEntity) surface = entity(i);
    const int type = surface.IsNull() ? 0 : surface->TypeNumber();
    if (isIGESSurface(type) && isIGESShape(type) && type != UnboundedPlane && surface->BlankStatus() == 0 &&
      parts.count(surface.get()) == 0 && faceCount(reader, surface) == 0)
    {
      throw Error(
        fileName + ": surface " + labelOf(model, i) + " (" + typeOf(model, i) + ") cannot be converted to a face");
    }
  }
}

/// Counts faces, and surfaces that stand for themselves, of which no face came.
void countLostFaces(STEPControl_Reader& reader, std::map<std::string, int>& dropped)
{
  const Handle(Interface_InterfaceModel) model = reader.WS()->Model();
  const auto count = [&](const Handle(Standard_Transient) & entity) {
    if (!entity.IsNull() && faceCount(reader, entity) == 0)
    {
      ++dropped[std::string(entity->DynamicType()->Name()) + " that is not converted to a face"];
    }
  };
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    if (model->Value(i)->IsKind(STANDARD_TYPE(StepShape_Face)))
    {
      count(model->Value(i));
    }
    const auto set = Handle(StepShape_GeometricSet)::DownCast(model->Value(i));
    for (int k = 1; !set.IsNull() && k <= set->NbElements(); ++k)
    {
      count(Handle(StepGeom_Surface)::DownCast(set->ElementsValue(k).Value()));
    }
  }
}

} // namespace

Shape readIGES(const std::string& opened, const std::string& fileName, OpenCASCADESession& session)
{
  Shape result;
  const auto iges = std::make_shared<IGESControl_Reader>();
  // Surfaces stay whole although their knots may be multiple, and numbers stay those of the file.
  session.set("read.iges.bspline.continuity", 0);
  if (iges->ReadFile(opened.c_str()) != IFSelect_RetDone || iges->IGESModel().IsNull())
  {
    throw Error(fileName + ": OpenCASCADE cannot read it as an IGES file");
  }
  const std::unordered_set<int> needed = neededEntities(iges->IGESModel());
  checkEntities(
    iges->IGESModel(), fileName, [&](int number, const std::string&) { return needed.count(number) > 0; },
    result.dropped);
  checkKnots(iges->IGESModel(), fileName);
  result.unit = igesUnit(iges->IGESModel()->GlobalSection());
  if (result.unit > 0.0)
  {
    iges->IGESModel()->ChangeGlobalSection().SetCascadeUnit(result.unit * 1000.0); // in millimetres
  }
  result.shape = transfer(*iges, result.dropped);
  checkFaces(*iges, fileName);
  const auto entity = [iges](const TopoDS_Face& face) {
    return Handle(IGESData_IGESEntity)::DownCast(iges->WS()->TransferReader()->EntityFromShapeResult(face, AnyResult));
  };
  result.name = [entity](const TopoDS_Face& face) {
    const Handle(IGESData_IGESEntity) found = entity(face);
    return found.IsNull() || !found->HasName() ? std::string() : textOf(found->NameValue());
  };
  result.layer = [entity](const TopoDS_Face& face) {
    const Handle(IGESData_IGESEntity) found = entity(face);
    return found.IsNull() || found->Level() <= 0 ? std::string() : std::to_string(found->Level());
  };
  BlankedEntities blanked(iges->IGESModel());
  std::unordered_set<const TopoDS_TShape*> hidden;
  for (int e = 1; e <= iges->IGESModel()->NbEntities(); ++e)
  {
    const auto blank = Handle(IGESData_IGESEntity)::DownCast(iges->IGESModel()->Value(e));
    if (!blank.IsNull() && isIGESSurface(blank->TypeNumber()) && isIGESShape(blank->TypeNumber()) && blanked.has(blank))
    {
      addFaces(shapeOf(*iges, blank), hidden);
    }
  }
  result.hidden = [hidden](const TopoDS_Face& face) { return hidden.count(face.TShape().get()) > 0; };
  return result;
}

Shape readSTEP(const std::string& opened, const std::string& fileName, const STEPEntities& entities)
{
  Shape result;
  const auto step = std::make_shared<STEPControl_Reader>();
  std::map<Standard_Transient*, std::string> layers;
  for (const auto& [keyword, count] : entities.broken)
  {
    result.dropped[keyword + " that refers to a missing entity"] += count;
  }
  if (step->ReadFile(opened.c_str()) != IFSelect_RetDone)
  {
    throw Error(fileName + ": OpenCASCADE cannot read it as a STEP file");
  }
  checkEntities(
    step->Model(), fileName,
    [&](int, const std::string& label) {
      // Labels are "#12".
      return label.size() < 2 || entities.needed.count(std::strtol(label.c_str() + 1, nullptr, 10)) > 0;
    },
    result.dropped);
  TColStd_SequenceOfAsciiString lengths, angles, solidAngles;
  step->FileUnits(lengths, angles, solidAngles);
  result.unit = lengths.IsEmpty() ? 0.0 : metres(lengths.First().ToCString());
  step->SetSystemLengthUnit(result.unit > 0.0 ? result.unit * 1000.0 : 1.0);
  result.shape = transfer(*step, result.dropped);
  countLostFaces(*step, result.dropped);
  const Handle(Interface_InterfaceModel) model = step->Model();
  const auto hidden = std::make_shared<HiddenFaces>(*step);
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    const auto assignment = Handle(StepVisual_PresentationLayerAssignment)::DownCast(model->Value(i));
    for (int k = 1; !assignment.IsNull() && k <= assignment->NbAssignedItems(); ++k)
    {
      layers[assignment->AssignedItemsValue(k).Value().get()] = textOf(assignment->Name());
    }
    const auto invisible = Handle(StepVisual_Invisibility)::DownCast(model->Value(i));
    for (int k = 1; !invisible.IsNull() && k <= invisible->NbInvisibleItems(); ++k)
    {
      hidden->add(invisible->InvisibleItemsValue(k));
    }
  }
  result.hidden = [step, hidden](const TopoDS_Face& face) { return hidden->has(face); };
  const auto entity = [step](const TopoDS_Face& face) {
    return step->WS()->TransferReader()->EntityFromShapeResult(face, AnyResult);
  };
  result.name = [entity](const TopoDS_Face& face) {
    const auto item = Handle(StepRepr_RepresentationItem)::DownCast(entity(face));
    const std::string name = item.IsNull() ? std::string() : textOf(item->Name());
    return name == "NONE" ? std::string() : name;
  };
  result.layer = [entity, layers](const TopoDS_Face& face) {
    const auto found = layers.find(entity(face).get());
    return found == layers.end() ? std::string() : found->second;
  };
  return result;
}

} // namespace bsv::cad
