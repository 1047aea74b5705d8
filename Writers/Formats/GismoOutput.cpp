// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/VolumeFormats.h"

#include "IO/TextOutput.h"
#include "Ranks/Ranks.h"

namespace bsv
{

namespace
{

/// Ids in the file: that of the multi-patch is 0.
constexpr int FirstPatch = 100;

std::string escaped(const std::string& text)
{
  std::string result;
  for (const char c : text)
  {
    switch (c)
    {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
  return result;
}

void writePatch(OutputBuffer& file, const BSplineVolume& volume, int id, bool rational, const PartReport& report)
{
  TextOutput out(file);
  const std::string kind = rational ? "TensorNurbs" : "TensorBSpline";
  out << " <Geometry type=\"" << kind << "3\" id=\"" << id << "\">\n";
  if (rational)
  {
    out << "  <Basis type=\"TensorNurbsBasis3\">\n";
  }
  out << "  <Basis type=\"TensorBSplineBasis3\">\n";
  for (int d = 0; d < 3; ++d)
  {
    out << "   <Basis type=\"BSplineBasis\" index=\"" << d << "\">\n    <KnotVector degree=\"" << volume.degree[d]
        << "\">";
    for (std::size_t i = 0; i < volume.knots[d].size(); ++i)
    {
      out << (i > 0 ? " " : "") << volume.knots[d][i];
    }
    out << "</KnotVector>\n   </Basis>\n";
  }
  out << "  </Basis>\n";
  const Index size = Index(volume.count(0)) * volume.count(1) * volume.count(2);
  if (rational)
  {
    out << "  <weights>\n";
    for (Index i = 0; i < size; ++i)
    {
      out << (volume.weights ? volume.weights[i] : 1.0) << "\n";
    }
    out << "  </weights>\n  </Basis>\n";
  }
  out << "  <coefs geoDim=\"3\">\n";
  for (Index i = 0; i < size; ++i)
  {
    if (i % 65536 == 0)
    {
      report(static_cast<double>(i));
    }
    out.point(volume.points + 3 * i);
  }
  out << "  </coefs>\n </Geometry>\n";
}

} // namespace

void writeGismo(const VolumeToWrite& volume, AtomicFile& file, const Execution& run)
{
  const int blocks = static_cast<int>(volume.volumes.size());
  const auto onFirst = [&](const auto& write) {
    if (run.ranks->rank() == 0)
    {
      TextOutput out(file);
      write(out);
    }
  };
  onFirst([&](TextOutput& out) {
    out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<xml>\n <MultiPatch parDim=\"3\" id=\"0\">\n"
        << "  <patches type=\"id_range\">" << FirstPatch << " " << FirstPatch + blocks - 1 << "</patches>\n"
        << "  <interfaces>\n";
    for (const Interface& c : volume.interfaces)
    {
      out << FirstPatch + c.blockA << " " << c.faceA + 1 << " " << FirstPatch + c.blockB << " " << c.faceB + 1 << " ";
      // Direction of the second patch that each direction of the first becomes, and whether in the same sense.
      std::array<int, 3> direction{};
      std::array<int, 3> same{};
      direction[faceDirection(c.faceA)] = faceDirection(c.faceB);
      same[faceDirection(c.faceA)] = faceSide(c.faceA) == faceSide(c.faceB) ? 1 : 0;
      for (int axis = 0; axis < 2; ++axis)
      {
        const int axisB = swapsAxes(c.orientation) ? 1 - axis : axis;
        direction[faceAxis(c.faceA, axis)] = faceAxis(c.faceB, axisB);
        same[faceAxis(c.faceA, axis)] = (c.orientation & (axisB == 0 ? 2 : 4)) != 0 ? 0 : 1;
      }
      for (const int d : direction)
      {
        out << " " << d;
      }
      out << " ";
      for (const int s : same)
      {
        out << " " << s;
      }
      out << "\n";
    }
    out << "  </interfaces>\n";
    const int names = static_cast<int>(volume.boundaryNames.size());
    for (int n = 0; n <= names; ++n)
    {
      std::string sides;
      for (const BoundaryPatch& patch : volume.boundaries)
      {
        if (patch.tag == (n < names ? n : -1))
        {
          sides += std::to_string(FirstPatch + patch.block) + " " + std::to_string(patch.face + 1) + "\n";
        }
      }
      if (!sides.empty())
      {
        out << "  <boundary" << (n < names ? " name=\"" + escaped(volume.boundaryNames[n]) + "\"" : std::string())
            << ">\n"
            << sides << "  </boundary>\n";
      }
    }
    out << " </MultiPatch>\n";
    for (int b = 0; b < blocks; ++b)
    {
      std::string name = volume.names[b];
      // Two hyphens would end the comment.
      for (std::size_t at = name.find("--"); at != std::string::npos; at = name.find("--"))
      {
        name.replace(at, 2, "- ");
      }
      out << " <!-- patch " << FirstPatch + b << ": " << escaped(name) << " -->\n";
    }
  });
  std::vector<FilePart> parts;
  const bool rational = run.ranks->any(volume.isRational());
  for (int b = 0; b < blocks; ++b)
  {
    const BSplineVolume& block = volume.volumes[b];
    parts.push_back({ block.rank, double(block.count(0)) * block.count(1) * block.count(2),
      [&block, b, rational](
        OutputBuffer& out, const PartReport& report) { writePatch(out, block, FirstPatch + b, rational, report); } });
  }
  writeParts(file, parts, run);
  onFirst([](TextOutput& out) { out << "</xml>\n"; });
}

} // namespace bsv
